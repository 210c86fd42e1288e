"""Distances of paths whatever the timing, and angles between velocities whatever the gain."""

import numpy as np
import pytest

from setcmas_ctrl.laws.script_loader import ALGORITHMS
from setcmas_simu.reports.script_calls import Function
from setcmas_tools.grade.solution_comparison import compared, frechet_distance
from setcmas_tools.offline.engine import simulate
from setcmas_tools.scenario.scenario import Scenario

CORNER = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [2, 2]], float)


@pytest.mark.parametrize(
    ('other', 'distance'),
    [
        (CORNER, 0),
        (np.repeat(CORNER, 3, axis=0), 0),  # slower
        (CORNER[:3], 0),  # ends earlier
        (CORNER + 0.25, np.hypot(0.25, 0.25)),
        (CORNER[::-1], np.sqrt(8)),  # the other way round
        (np.array([[0, 0], [1, 1], [2, 2]], float), np.sqrt(2)),  # cuts the corner
    ],
)
def test_paths_are_compared_in_space(other, distance):
    assert frechet_distance(CORNER, other) == pytest.approx(distance)
    assert frechet_distance(other, CORNER) == pytest.approx(distance)


@pytest.mark.parametrize(
    ('turned_by', 'gain', 'degrees'), [(0, 3, 0), (20, 1, 20), (180, 0.2, 180), (0, 0, 180)]
)
def test_a_wrong_gain_does_not_change_the_direction(turned_by, gain, degrees):
    def law(robotNo, nbRobots, poses, t):
        positions = poses[0] + 1j * poses[1]
        velocity = gain * (positions.mean() - positions[robotNo - 1])
        velocity *= np.exp(1j * np.radians(turned_by))
        return velocity.real, velocity.imag

    script = ALGORITHMS.file('consensus')
    base = Scenario.of('', nb_robots=3, duration=3)
    run, solution = simulate(base.replace(algo=law)), simulate(base.replace(algo=str(script)))

    found = compared(['direction_error'], run, solution, base, script, function=Function.CONTROL)
    assert found['direction_error'] == pytest.approx(degrees, abs=1e-3)


@pytest.mark.parametrize(('gain', 'error'), [(0.1, 0.0), (0.15, 0.5)])
def test_a_solution_gets_the_messages_that_a_submission_received(gain, error):
    options = {'nb_robots': 4, 'duration': 6, 'graph': 'path', 'loss': 0.2, 'vnom': 5}
    options['set'] = {'NUMBERS': [3, 1, 4, 2], 'K': 0.1}
    script = ALGORITHMS.file('leader_election')
    right = Scenario.of(str(script), **options)
    run, solution = (simulate(right, set=options['set'] | {'K': k}) for k in (gain, 0.1))

    found = compared(
        ['answer_error', 'direction_error'], run, solution, right, script, Function.CONTROL
    )

    assert found == {
        'answer_error': pytest.approx(error / 1.5, abs=1e-3),
        'direction_error': pytest.approx(0.0, abs=1e-3),
    }


@pytest.mark.parametrize(('robots', 'degrees'), [((), 60.0), ((2, 3), 0.0), ((1,), 180.0)])
def test_answers_of_some_robots_are_compared(tmp_path, robots, degrees):
    script = ALGORITHMS.file('consensus')
    law = tmp_path / 'law.py'
    law.write_text(
        f'{script.read_text()}\nright = control\ndef control(i, *rest):\n'
        '    return right(i, *rest) if i > 1 else (0, 0)\n'
    )
    base = Scenario.of('', nb_robots=3, duration=3)
    run, solution = simulate(base.replace(algo=str(law))), simulate(base.replace(algo=str(script)))

    found = compared(['direction_error'], run, solution, base, script, Function.CONTROL, robots)
    assert found['direction_error'] == pytest.approx(degrees, abs=1e-3)
