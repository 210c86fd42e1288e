"""Scenarios of a rubric in the emulated lab."""

import pytest
from processes import run_setcmas

from launch_scripts.cli import build_parser
from launch_scripts.processes.emulated_runs import command_line
from setcmas_ctrl.control.control_options import LawOptions
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


def test_a_scenario_is_a_command_that_means_the_same(rubric):
    [scenario] = read_rubric(rubric).scenarios
    line = ['run', '--emulate', *command_line(scenario.of('my_law.py'))]
    args = build_parser('run').parse_args(line)
    assert (args.algo, args.nb_robots, args.duration, args.loss) == ('my_law.py', 2, 6, 0.1)
    assert (args.event_triggered, args.filter) == (True, 'none')
    assert args.poses == {1: (1.0, 1.0, 0.5), 2: (-1.0, -1.0, 0.0)}
    rubric.write_text(RUBRIC.replace('loss: 0.1', 'set: {WPL: [[1, 2]], REACHED: 0.2}'))
    [scenario] = read_rubric(rubric).scenarios
    args = build_parser('run').parse_args(['run', *command_line(scenario.of('my_law.py'))])
    assert LawOptions.of(args).set == {'WPL': [[1, 2]], 'REACHED': 0.2}


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
