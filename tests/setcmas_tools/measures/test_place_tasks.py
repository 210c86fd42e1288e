import math

import numpy as np
import pytest
from metrics_runs import T, table
from runs import measure

from setcmas_ctrl.laws.references import References, checked_references
from setcmas_simu.errors import SetcmasError

BOX = References('coverage', {'BOX': [[-1, -2], [3, 2]]})


def test_tracking_errors():
    radius = np.where(T < 10, 2.5, 2.1)
    fleet = table((T, radius * np.cos(0.2 * T), radius * np.sin(0.2 * T)))

    references = References('tracking', {'R': 2.0, 'W': 0.2})
    errors = measure(fleet, references=references)['tracking']

    whole = math.sqrt((100 * 0.5**2 + 101 * 0.1**2) / 201)
    assert errors.tracking_error_rms_m == pytest.approx({1: whole})
    assert errors.tracking_error_rms_second_half_m == pytest.approx({1: 0.1})
    assert errors.fleet_tracking_error_rms_m == pytest.approx(whole)


def test_waypoints_are_reached_in_the_order_of_the_list():
    # At 0.1 m/s along x the distance to (1, 0) is below 0.055 m from 9.5 s on.
    fleet = table((T, 0.1 * T, 0), (T, 3 - 0.1 * T, 0))
    references = References('waypoints', {'WPL': [[1, 0], [1.5, 0]], 'REACHED': 0.055})

    visits = measure(fleet, references=references)['waypoints']

    assert visits.waypoints_m == [[1.0, 0.0], [1.5, 0.0]]
    assert visits.reached_within_m == 0.055
    assert visits.reached_at_s == {1: [9.5, 14.5], 2: [19.5]}


def test_a_list_of_waypoints_is_gone_through_again():
    references = References('waypoints', {'WPL': [[1.0, 0], [0, 0]], 'REACHED': 0.01})
    x = np.select([T < 3, T < 6, T < 7], [0, 1, 0], 1)

    visits = measure(table((T, x, 0)), references=references)['waypoints']

    assert visits.reached_at_s == {1: [3.0, 6.0, 7.0]}


def test_the_cost_of_a_robot_is_the_second_moment_of_the_box():
    still = measure(table((T, 1, 0)), references=BOX)['coverage']
    away = measure(table((T, 1 + 0.1 * T, 0)), references=BOX)['coverage']

    assert still.cost_at_start_m4 == pytest.approx(16 * (16 + 16) / 12, rel=1e-3)
    assert still.largest_rise_percent == 0.0
    assert away.cost_at_end_m4 == pytest.approx(16 * (32 / 12 + 4), rel=1e-3)
    assert away.largest_rise_percent == pytest.approx(150, abs=0.2)


def test_a_robot_that_is_missing_at_times_costs_nothing_then():
    two = measure(table((T, 0, 0), (T[:100], 2, 0)), references=BOX)['coverage']

    assert two.cost_at_end_m4 == two.cost_at_start_m4 == pytest.approx(16 * 20 / 12, rel=1e-3)
    assert 'coverage' not in measure(table((T, 0, np.nan)), references=BOX)


@pytest.mark.parametrize(
    'box', [3, [[0, 0]], [[0, 0], [1, 0]], [[1, 1], [0, 0]], [[0, 0], [1e200, 1]]]
)
def test_a_box_has_two_corners(box):
    with pytest.raises(SetcmasError, match=r'BOX is .*must be'):
        checked_references('coverage', {'BOX': box}, 'law.py')
