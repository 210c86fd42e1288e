import shutil
import signal

import pytest
import yaml
from processes import SETCMAS, refuses, run_here

from setcmas_tools.offline.script_process import ScriptProcess
from setcmas_tools.run.run_info import RunInfo, write_info
from setcmas_tools.run.run_tables import read_fleet

NAV = '--algo nav_wp'


def offline(tmp_path, *arguments, plots=False):
    drawn = () if plots else ('--no-plots',)
    result = run_here('offline', *arguments, *drawn, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    return result


def test_a_run_is_repeated_from_what_it_keeps(tmp_path):
    given = {
        'leader.py': 'import gains\nW = 0\ndef control(i, n, p, t):\n    return gains.K, W\n',
        'gains.py': 'K = 0.3\n',
        'law.py': 'K = 0.5\ndef control(i, n, p, t):\n    return K * (i - p[0, i - 1]), 0\n',
        'side.py': 'def step(state, command, Ts):\n    return state[0] + Ts, *state[1:]\n',
        'when.py': 'def ctc(pos, last_pos, t):\n    return t > 1\n',
        'mine.py': 'def si_to_uni(velocity, pose, komega):\n    return velocity[0], 0.1\n',
        'switch.yaml': 'segments:\n  - {duration: 1, graph: ring}\n  - {graph: star}\n',
        'places.yaml': 'tb3_1: [1, 2, 0]\n',
    }
    for name, text in given.items():
        (tmp_path / name).write_text(text)
    options = ('--nb-robots', '3', '--duration', '3', '--event-triggered', '--loss', '0.5')
    options += ('--set', 'K=0.2')

    def run(folder, **files):
        named = [text for name, file in files.items() for text in (f'--{name}', str(file))]
        assert offline(tmp_path, *options, *named, '--output', folder).returncode == 0
        return {path.name: path.read_bytes() for path in (tmp_path / folder / 'csv').iterdir()}

    names = {'algo': '1:leader,2-3:law', 'ctc': 'when', 'si-to-uni': 'mine'}
    names |= {'model': '2:side.py,3:car'}
    names |= {'graph': 'switch.yaml', 'poses': 'places.yaml'}
    first = run('first', **names)
    for name in given:
        (tmp_path / name).unlink()

    result = offline(tmp_path, '--from', 'first', '--output', 'again')
    again = {path.name: path.read_bytes() for path in (tmp_path / 'again' / 'csv').iterdir()}

    assert again == first
    assert f'identical to first: all {len(first)} files of its csv' in result.stdout
    other = offline(tmp_path, '--from', 'first', '--duration', '2', '--output', 'other')
    assert 'compared with first: this run is 0 m apart (RMS), at most 0 m (' in other.stdout
    assert 'setcmas compare shows the metrics' in other.stdout
    shutil.rmtree(tmp_path / 'first' / 'csv')
    unfinished = offline(tmp_path, '--from', 'first', '--output', 'third')
    assert unfinished.returncode == 0
    assert 'not compared with first: there is no fleet.csv' in unfinished.stdout


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (f'{NAV} --duration 1e9', 'the run would store 1e+10 states of robots (about'),
        (f'{NAV} --ctc x.py', '--ctc needs --event-triggered'),
        (f'{NAV} --output=', "--output is ''; it must be a path"),
        (f'{NAV} --output {"a" * 300}', 'cannot be written: File name too'),
        ('--from nowhere', "there is no run.yaml in 'nowhere'"),
        ('--from nowhere', 'to simulate a recording, give its law and start poses'),
        ('--from old', "there is no key 'parameters'"),
        ('--from empty', 'there is no control law; add algo'),
        ('', 'add --algo, or a scenario file, or --from'),
    ],
)
def test_mistakes_are_reported_in_one_line(tmp_path, arguments, message):
    for name in ('old', 'empty'):
        (tmp_path / name).mkdir()
    (tmp_path / 'old' / 'run.yaml').write_text('parameters: {algo: nav_wp}\n')
    write_info(RunInfo(), tmp_path / 'empty')

    refuses('offline', '--no-plots', *arguments.split(), message=message, cwd=tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {'old', 'empty'}


@pytest.mark.parametrize(
    ('law', 'options', 'message', 'failed'),
    [
        ('(1 / (i - 2), 0)', (), 'law.py failed for robot 2;', {'law.py': [2]}),
        (
            '(1, 0)',
            ('--event-triggered', '--ctc', 'when.py'),
            'when.py failed for robots 1-3;',
            {'when.py': [1, 2, 3]},
        ),
    ],
)
def test_a_failed_script_is_reported_at_the_end(tmp_path, law, options, message, failed):
    (tmp_path / 'law.py').write_text(f'def control(i, n, p, t):\n    return {law}\n')
    (tmp_path / 'when.py').write_text('def ctc(pos, last_pos, t):\n    return None\n')
    options = ('--algo', 'law', '--nb-robots', '3', '--duration', '1', '-o', 'out', *options)

    result = run_here('offline', '--no-plots', *options, cwd=tmp_path)

    assert result.returncode == 1
    assert f'setcmas offline: complete, but {message}' in result.stderr.splitlines()[-1]
    record = yaml.safe_load((tmp_path / 'out' / 'run.yaml').read_text())
    assert record['command'][:2] == ['setcmas', 'offline']
    assert record['outcome'] == {'state': 'failed', 'failed': failed}


def test_ctrl_c_keeps_what_was_simulated(start, tmp_path):
    (tmp_path / 'law.py').write_text(
        'def control(i, n, p, t):\n'
        '    while t >= 2:\n        print("here", flush=True)\n    return 0.1, 0\n'
    )
    options = ('--no-plots', '--call-timeout', '100')  # the flood of lines keeps this test busy
    process = start(*SETCMAS, 'offline', *options, '--algo', 'law', '-o', 'out', cwd=tmp_path)
    process.wait_for_output('here')

    assert process.end(signal.SIGINT) == 130
    assert 'the first 2 s are written' in process.output()
    assert '2 s in ' in process.output()
    record = yaml.safe_load((tmp_path / 'out' / 'run.yaml').read_text())
    assert record['outcome'] == {'state': 'stopped'}
    assert read_fleet(tmp_path / 'out' / 'csv' / 'fleet.csv').t[-1] == 2.0


def test_ctrl_c_while_the_run_begins(tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(ScriptProcess, '_answer', interrupted)
    result = run_here('offline', '--algo', 'consensus', cwd=tmp_path)

    assert result.returncode == 130
    assert 'stopped by the user' in result.stderr


@pytest.mark.parametrize(('wait', 'is_slow'), [(0.15, True), (0, False)])
def test_a_law_that_is_slower_than_real_time_is_told(tmp_path, wait, is_slow):
    (tmp_path / 'law.py').write_text(
        f'import time\ndef control(i, n, p, t):\n    time.sleep({wait})\n    return 0.1, 0\n'
    )
    result = offline(tmp_path, '--algo', 'law.py', '--nb-robots', '2', '--duration', '1')

    assert ('this law is slower than real time: ' in result.stderr) == is_slow
