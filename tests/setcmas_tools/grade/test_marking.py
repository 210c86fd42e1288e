"""Marks from runs: what needs something else, what is hidden, what scripts say of themselves."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from setcmas_ctrl.algorithms.consensus import control
from setcmas_ctrl.laws.script_loader import ALGORITHMS
from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function
from setcmas_tools.grade.check import runs_here
from setcmas_tools.grade.criteria import Criterion
from setcmas_tools.grade.mark_records import Marks, ScenarioRun
from setcmas_tools.grade.marking import compared, mark
from setcmas_tools.grade.rubric import MarkedScenario, read_rubric
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.run.scenario import Scenario
from setcmas_tools.submissions.submissions import Submission
from setcmas_tools.submissions.submitted_files import Student

RUBRIC = """\
solution: leader_follower_formation
scenarios:
  - name: shown
    nb_robots: 3
    duration: 4
    criteria:
      - {name: places, metric: position_error, at_most: 0.1, points: 2, hint: Take your place.}
      - {name: apart, metric: least_separation, at_least: 0.1, needs: places}
  - name: kept
    hidden: true
    nb_robots: 3
    duration: 1
    criteria: [{metric: least_separation, at_least: 0.1, hidden: true}]
"""
FORGING = """\
task = 'formation'
PLACES = [[-5, 0], [0, 0]]  # where they are

def control(robotNo, nbRobots, poses, t):
    return 0, 0
"""

NAMELESS = Submission('', Student(''))


@pytest.fixture
def rubric(tmp_path):
    (tmp_path / 'r.yaml').write_text(RUBRIC)
    return read_rubric(tmp_path / 'r.yaml')


def test_a_script_cannot_say_what_it_is_measured_by(rubric, tmp_path):
    script = tmp_path / 'forging.py'
    script.write_text(FORGING)
    marks = mark(rubric, runs_here(str(script)), Submission('forging', Student('Eve')))
    shown, kept = marks.scenarios
    assert [one.points for one in shown.criteria] == [0, 0]
    assert shown.criteria[1].reached > 0.1  # apart, but not where they have to be
    assert shown.criteria[1].hint == "This counts only with points for 'places'."
    assert (kept.points, kept.hidden, kept.paths) == (1, True, ())
    assert [len(path.wanted) for path in shown.paths] == [41, 41, 41]
    assert msgspec.json.decode(msgspec.json.encode(marks), type=Marks) == marks


def test_a_run_that_did_not_reach_its_end_has_no_points(rubric):
    run = runs_here('leader_follower_formation')

    def broken(scenario):
        return ScenarioRun(run(scenario).run, is_complete=False)

    assert mark(rubric, broken, NAMELESS).score == 0
    assert mark(rubric, run, NAMELESS).score > 0


def test_what_was_not_reached_says_why(rubric, tmp_path):
    text = """\
solution: consensus
scenarios:
  - {name: all, nb_robots: 3, duration: 9, criteria: [{metric: settling_time, at_most: 9}]}
"""
    (tmp_path / 'r.yaml').write_text(text)
    rubric = read_rubric(tmp_path / 'r.yaml')

    def reached(line, run=None):
        script = tmp_path / 'law.py'
        script.write_text(f'def control(i, n, poses, t):\n    {line}\n')
        marks = mark(rubric, run or runs_here(str(script)), NAMELESS)
        return marks.scenarios[0].criteria[0].reached_text

    assert reached('return 0, 0') == 'none: no robot moved'
    assert reached('return i, 0') == 'none: it never got there'
    assert reached('return 1 / 0, 0') == 'none: the script failed'
    assert reached('', lambda _: ScenarioRun(None)) == 'none: it did not run'


def test_a_solution_that_fails_is_the_teachers_to_mend(tmp_path):
    (tmp_path / 'r.yaml').write_text(RUBRIC.replace('leader_follower_formation', 'bad.py', 1))
    (tmp_path / 'bad.py').write_text(FORGING.replace('return 0, 0', 'return 1 / 0'))
    rubric = read_rubric(tmp_path / 'r.yaml')
    with pytest.raises(SetcmasError, match=r"scenario 'shown' of .*bad\.py, line 5"):
        mark(rubric, runs_here('consensus'), NAMELESS)


@pytest.mark.parametrize(('shift', 'slower', 'distance'), [(0.25, 1.0, 0.25), (0.0, 2.0, 0.0)])
def test_paths_are_compared_in_space_whatever_the_timing(shift, slower, distance):
    def driven(y, speed):
        def law(robotNo, nbRobots, poses, t):
            return speed, 5 * (y - poses[1, 0])

        return simulate(base.replace(algo=law))

    base = Scenario.of('', nb_robots=1, duration=20, poses={1: [0, 0, 0]})
    run, solution = driven(shift, 0.2 / slower), driven(0.0, 0.2)

    found = compared(asked(base, 'path_distance'), run, solution, None, Function.CONTROL)
    assert found['path_distance'] == pytest.approx(distance, abs=0.1)


def asked(base, *metrics):
    """Return a scenario with a criterion for each metric."""
    return MarkedScenario('', tuple(Criterion(one, one, 1.0) for one in metrics), base)


@pytest.mark.parametrize(('turned_by', 'gain', 'degrees'), [(0, 3, 0), (20, 1, 20), (0, 0, 180)])
def test_a_wrong_gain_does_not_change_the_direction(turned_by, gain, degrees):
    def law(robotNo, nbRobots, poses, t):
        positions = poses[0] + 1j * poses[1]
        velocity = gain * (positions.mean() - positions[robotNo - 1])
        velocity *= np.exp(1j * np.radians(turned_by))
        return velocity.real, velocity.imag

    script = ALGORITHMS.file('consensus')
    base = Scenario.of('', nb_robots=3, duration=3)
    run, solution = simulate(base.replace(algo=law)), simulate(base.replace(algo=str(script)))

    found = compared(asked(base, 'direction_error'), run, solution, script, Function.CONTROL)
    assert found['direction_error'] == pytest.approx(degrees, abs=1e-3)


@pytest.mark.parametrize(('gain', 'error'), [(0.1, 0.0), (0.15, 0.5)])
def test_a_solution_gets_the_messages_that_a_submission_received(gain, error):
    options = {'nb_robots': 4, 'duration': 6, 'graph': 'path', 'loss': 0.2, 'vnom': 5}
    options['set'] = {'NUMBERS': [3, 1, 4, 2], 'K': 0.1}
    script = ALGORITHMS.file('leader_election')
    right = Scenario.of(str(script), **options)
    run, solution = (simulate(right, set=options['set'] | {'K': k}) for k in (gain, 0.1))

    scenario = asked(right, 'answer_error', 'direction_error')
    found = compared(scenario, run, solution, script, Function.CONTROL)

    assert found == {
        'answer_error': pytest.approx(error / 1.5, abs=1e-3),
        'direction_error': pytest.approx(0.0, abs=1e-3),
    }


@pytest.mark.parametrize(('robots', 'degrees'), [((), 60.0), ((2, 3), 0.0)])
def test_answers_of_some_robots_are_compared(robots, degrees):

    def law(robotNo, nbRobots, poses, t):
        return control(robotNo, nbRobots, poses, t) if robotNo > 1 else (0, 0)

    script = ALGORITHMS.file('consensus')
    base = Scenario.of('', nb_robots=3, duration=3)
    run, solution = simulate(base.replace(algo=law)), simulate(base.replace(algo=str(script)))

    scenario = replace(asked(base, 'direction_error'), robots=robots)
    found = compared(scenario, run, solution, script, Function.CONTROL)
    assert found['direction_error'] == pytest.approx(degrees, abs=1e-3)
