"""Scenarios of a rubric in the emulated lab."""

from types import MappingProxyType

import pytest
from processes import run_here, run_setcmas

from launch_scripts.cli import build_parser
from launch_scripts.commands.scenario_options import scenario_of
from launch_scripts.processes.emulated_runs import bounded_lab_options, in_lab, passed_on
from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade.rubric import read_rubric
from setcmas_tools.run.inputs import inputs_of, kept_record
from setcmas_tools.run.run_info import RunInfo, write_info
from setcmas_tools.scenario.scenario import Scenario

RUBRIC = """\
title: Final
solution: nav_wp
scenarios:
  - name: two robots
    nb_robots: 2
    duration: 6
    poses: [[1, 1, 0.5], [-1, -1, 0]]
    loss: 0.1
    event_triggered: true
    filter: none
    criteria:
      - {name: like the solution, metric: path_error, at_most: 0.3}
      - {name: no robot is stopped, metric: safety_stops, at_most: 0}
"""


@pytest.fixture
def rubric(tmp_path):
    (tmp_path / 'final.yaml').write_text(RUBRIC)
    return tmp_path / 'final.yaml'


@pytest.mark.parametrize('further', ['loss: 0.1', 'set: {WPL: [[1, 2]], REACHED: 0.2}'])
def test_a_scenario_reaches_the_command_that_runs_it(rubric, further):
    rubric.write_text(RUBRIC.replace('loss: 0.1', further))
    [marked] = read_rubric(rubric).scenarios
    scenario = marked.of('my_law.py')
    args = build_parser('run').parse_args(['run', '--emulate', *passed_on(scenario)])
    passed = scenario_of(args)
    assert passed.replace(poses=None) == scenario.replace(poses=None, emulate=True)
    assert (passed.robots.start_poses(2) == scenario.robots.start_poses(2)).all()


TIGHT = """\
algo: consensus
nb_robots: 2
emulate: true
arena: [-2, 2, -2, 2]
min_separation: 0.5
obstacles: disc 0 1.5 0.1
accel: 0.4
"""


def lab_of(scenario, typed=MappingProxyType({}), from_file=True):
    return bounded_lab_options(scenario, typed, from_file, nb_robots=2).chosen()


def kept_run(scenario, folder):
    """Write the run.yaml of an emulated run, with its inputs; return the recorded scenario."""
    found = in_lab(scenario, lab_of(scenario)).found()
    inputs = inputs_of(found)
    folder.mkdir()
    for one in inputs:
        one.write_to(folder / one.folder)
    write_info(RunInfo(scenario=kept_record(found, inputs)), folder)
    return Scenario.load(folder / 'run.yaml')


def test_a_scenario_tightens_its_lab_and_the_run_repeats_in_the_same(tmp_path):
    (tmp_path / 'tight.yaml').write_text(TIGHT)
    scenario = Scenario.load(tmp_path / 'tight.yaml')
    lab = lab_of(scenario)
    assert (lab.arena, lab.min_separation, lab.accel) == ((-2, 2, -2, 2), 0.5, 0.4)

    again = kept_run(scenario, tmp_path / 'out')
    assert lab_of(again, from_file=False) == lab  # run --from
    assert lab_of(again) == lab  # run out/run.yaml
    (tmp_path / 'small.yaml').write_text('arena: {x: [-1, 1], y: [-1, 1]}')
    with pytest.raises(SetcmasError, match='arena of the scenario loosens'):
        lab_of(again, {'lab': tmp_path / 'small.yaml'})


@pytest.mark.parametrize('verb', ['run', 'expe'])
def test_a_scenario_that_loosens_its_lab_starts_nothing(verb, tmp_path):
    (tmp_path / 'wide.yaml').write_text(TIGHT.replace('[-2, 2, -2, 2]', '[-9, 9, -9, 9]'))
    result = run_here(verb, 'wide.yaml', cwd=tmp_path)
    assert result.returncode == 2
    assert 'arena of the scenario loosens what the lab file sets' in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ['wide.yaml']


@pytest.mark.nightly
@pytest.mark.ros
def test_a_law_is_marked_for_safety_in_the_lab(rubric, domain):
    folder = rubric.parent
    run_setcmas('new', 'my_law', '--from', 'nav_wp', cwd=folder)
    offline = run_setcmas('check', 'my_law', '-R', 'final.yaml', cwd=folder)
    emulated = run_setcmas('check', 'my_law', '-R', 'final.yaml', '--emulate', cwd=folder)
    assert offline.returncode == 2
    assert 'only measured in the emulated lab; add --emulate' in offline.stderr
    assert 'no robot is stopped: safety_stops 0 (wanted: at most 0)' in emulated.stdout
    assert emulated.returncode == 0

    (folder / 'my_law.py').write_text(
        'def control(robotNo, nbRobots, poses, t):\n    return (0.1, 0) if t < 1 else (boom, 0)\n'
    )
    failing = run_setcmas('check', 'my_law', '-R', 'final.yaml', '--emulate', cwd=folder)
    assert " s: my_law.py, line 2: NameError: name 'boom' is not defined" in failing.stdout
    assert '  not finished: the robots were paused' in failing.stdout
