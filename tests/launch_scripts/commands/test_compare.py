from dataclasses import replace

import pytest
from processes import refuses

from launch_scripts.cli import main
from setcmas_tools import simulate
from setcmas_tools.run.law_output import safety_record
from setcmas_tools.run.run import Run

LAW = """K = 0.5


def control(robotNo, nbRobots, poses, t):
    x, y = K * (poses[:2].mean(axis=1) - poses[:2, robotNo - 1])
    return x, y
"""


@pytest.fixture
def folders(tmp_path, monkeypatch):
    """Two runs that differ in gain and largest speed."""
    monkeypatch.chdir(tmp_path)
    law = tmp_path / 'law.py'
    for name, gain, vnom in (('one', '0.5', 0.5), ('other', '0.8', 0.4)):
        law.write_text(LAW.replace('0.5', gain))
        simulate(law, 3, 8.0, vnom=vnom).save(name)
    return tmp_path


def test_two_gains_are_compared(folders, capsys):
    """In metrics, script and parameters, and in two pictures."""
    assert main(['compare', 'one', 'other']) == 0

    lines = [' '.join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert 'vnom_m_s 0.5 0.4 -0.1' in lines
    assert 'vnom: 0.5 -> 0.4' in lines
    assert lines[lines.index('-K = 0.5') + 1] == '+K = 0.8'
    assert any(line.startswith('other is 0.') for line in lines)
    pictures = {path.name for path in (folders / 'comparison').iterdir()}
    assert pictures == {'paths.png', 'distances.png'}


def test_one_run_alone_is_refused(folders):
    refuses('compare', 'one', message="'one' is only one run; name at least two", cwd=folders)


def test_robots_of_an_experiment_depart_from_their_simulation(folders, capsys):
    """In either order, printed and on the page."""
    run = Run.load('other')
    safety = safety_record(
        [(t / 2, robot, 'moving', False) for t in range(16) for robot in (1, 2)]
    )
    replace(run, tables=replace(run.tables, safety=safety)).save('experiment')

    for arguments in (['one', 'experiment'], ['experiment', 'one']):
        assert main(['compare', *arguments]) == 0
        printed = capsys.readouterr().out
        assert 'tb3_1 ' in printed.partition('more than 0.1 m away from (s)')[2]
    assert main(['compare', 'one', 'other']) == 0
    assert 'away from' not in capsys.readouterr().out
    assert main(['report', 'one', 'experiment']) == 0
    assert 'Experiment against simulation' in (folders / 'one_experiment.html').read_text()
