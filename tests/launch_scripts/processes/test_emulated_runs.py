"""Scenarios of a rubric in the emulated lab."""

import pytest
from processes import run_setcmas

from launch_scripts.cli import build_parser
from launch_scripts.commands.scenario_options import scenario_of
from launch_scripts.processes.emulated_runs import passed_on
from setcmas_tools.grade.rubric import read_rubric

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
      - {name: nobody is stopped, metric: safety_stops, at_most: 0}
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


@pytest.mark.nightly
@pytest.mark.ros
def test_a_law_is_marked_for_safety_in_the_lab(rubric, domain):
    folder = rubric.parent
    run_setcmas('new', 'my_law', '--from', 'nav_wp', cwd=folder)
    offline = run_setcmas('check', 'my_law', '-R', 'final.yaml', cwd=folder)
    emulated = run_setcmas('check', 'my_law', '-R', 'final.yaml', '--emulate', cwd=folder)
    assert offline.returncode == 2
    assert 'only measured in the emulated lab; add --emulate' in offline.stderr
    assert 'nobody is stopped: safety_stops 0 (wanted: at most 0)' in emulated.stdout
    assert emulated.returncode == 0
