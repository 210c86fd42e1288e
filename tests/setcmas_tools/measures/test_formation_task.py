import math

import numpy as np
import pytest
from metrics_runs import T, table
from runs import measure

from setcmas_ctrl.laws.references import References
from setcmas_tools.measures.formation_task import distance_errors
from setcmas_tools.run.fleet_motion import FleetGrid


def test_position_errors_of_a_formation():
    late = np.where(T < 10, 1.0, 0.0)
    fleet = table((T, 0.1 * T, 0), (T, 0.1 * T - 0.7, 0.4), (T, 0.1 * T, 1 + late), (T, 9, 9))
    references = References('formation', {'PLACES': [[-1.0, 0.0], [0.0, 1.0]]})

    errors = measure(fleet, references=references)['formation']

    assert errors.position_error_final_m == pytest.approx({2: 0.5, 3: 0.0})
    assert errors.position_error_rms_last_quarter_m == pytest.approx({2: 0.5, 3: 0.0})
    assert errors.fleet_position_error_rms_last_quarter_m == pytest.approx(0.5 / math.sqrt(2))


@pytest.mark.parametrize(
    ('D', 'errors'),
    [
        (3.0, {'1-2': 0.0, '1-3': 1.0, '2-3': 2.0}),
        ([[5, 5], [8, 5], [5, 8]], {'1-2': 0.0, '1-3': 1.0, '2-3': 5 - math.sqrt(18)}),
        ([[5, 5], [9, 5]], {'1-2': -1.0}),  # a robot without a point is not measured
    ],
)
def test_distance_errors_of_a_formation(D, errors):
    fleet = table((T, 0, 0), (T, 3, 0), (T, 0, 4))
    rms = math.sqrt(sum(error**2 for error in errors.values()) / len(errors))

    found = measure(fleet, references=References('distances', {'D': D}))['distances']

    assert found.distance_errors_final_m == pytest.approx(errors)
    assert found.distance_error_final_rms_m == pytest.approx(rms)
    assert found.distance_error_rms_last_quarter_m == pytest.approx(rms)
    assert found.distance_error_final_largest_m == pytest.approx(max(map(abs, errors.values())))


def test_a_robot_without_a_point_has_no_curve():
    grid = FleetGrid(T, [1, 2, 3], *np.zeros((3, 3, len(T))))

    assert distance_errors(grid, [[5, 5], [9, 5]]).keys() == {1, 2}
