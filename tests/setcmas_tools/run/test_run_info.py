import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.run import run_info
from setcmas_tools.run.run_info import (
    Outcome,
    RunInfo,
    RunState,
    read_info,
    this_origin,
    write_info,
)
from setcmas_tools.run.scenario import Scenario

INFO = RunInfo(
    ['setcmas', 'run'],
    Outcome.of_calls([('law.py', 3), ('when.py', 1), ('law.py', 2), ('law.py', 3)]),
    {'nb_robots': 3, 'range': None, 'set': {'K': 1.2}, 'seed': 7, 'algo': 'inputs/algo/law.py'},
    {'robot_rate': None},
    '2026-11-21T16:02:11+0000',
    this_origin(),
)


def test_the_outcome_in_words():
    assert str(INFO.outcome) == (
        'complete, but law.py failed for robots 2-3 and when.py failed for robot 1'
    )
    assert str(Outcome(RunState.DIED, detail='tb3_1 was killed')) == 'died: tb3_1 was killed'
    assert str(Outcome(RunState.STOPPED)) == 'stopped by the user'


def test_the_origin_names_packages_and_plugins(monkeypatch):
    monkeypatch.setattr(run_info, 'plugin_versions', lambda: {'my-lab': '1.0'})
    this_origin.cache_clear()
    origin = this_origin()

    assert origin.setcmas.startswith('0.')
    assert origin.host['name']
    assert origin.versions['my-lab'] == '1.0'
    assert {'numpy', 'rosbags'} < origin.versions.keys()
    this_origin.cache_clear()


def test_values_that_this_version_no_longer_has_are_left_out(tmp_path):
    write_info(INFO, tmp_path)
    path = tmp_path / 'run.yaml'
    path.write_text(path.read_text().replace('scenario:\n', 'scenario:\n  lookahead: 0.1\n'))

    assert read_info(tmp_path).seed == INFO.seed
    (tmp_path / 'inputs/algo').mkdir(parents=True)
    (tmp_path / 'inputs/algo/law.py').write_text(
        'def control(i, n, p, t):\n    return K, 0\nK = 1\n'
    )
    assert Scenario.load(path).seed == INFO.seed


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        (('format: 1', 'format: 2'), r"run\.yaml' has format 2; this setcmas reads format 1 only"),
        (('format: 1\n', ''), 'has format none'),
        (('seed: 7', 'seed: seven'), r"line 12: scenario\.seed is 'seven'; it"),
        (
            ('state: failed', 'state: lost'),
            r"run\.yaml' is damaged: Invalid enum value 'lost' - at `\$\.outcome\.state`",
        ),
        (('seed: 7', 'seed: ['), r'run\.yaml, line \d+: not YAML'),
        (('nb_robots: 3', 'version: 2\n  nb_robots: 3'), 'version is 2; it must be 1, the only'),
    ],
)
def test_another_or_a_damaged_record_gets_a_line(tmp_path, change, message):
    write_info(INFO, tmp_path)
    path = tmp_path / 'run.yaml'
    path.write_text(path.read_text().replace(*change))

    with pytest.raises(SetcmasError, match=message) as caught:
        read_info(tmp_path)
    assert '\n' not in str(caught.value)
