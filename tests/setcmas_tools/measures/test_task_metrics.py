import math

import numpy as np
import pytest
from metrics_runs import T, table
from runs import measure

from setcmas_ctrl.laws.references import References, box
from setcmas_tools import simulate
from setcmas_tools.measures.task_errors import distance_errors
from setcmas_tools.measures.task_metrics import spread
from setcmas_tools.run.fleet_motion import FleetGrid
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_records import Commands

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
    'corners', [3, [[0, 0]], [[0, 0], [1, 0]], [[1, 1], [0, 0]], [[0, 0], [1e200, 1]]]
)
def test_a_box_has_two_corners(corners):
    with pytest.raises(ValueError, match='it must be'):
        box(corners)


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


@pytest.mark.parametrize(
    ('degrees', 'expected'),
    [([10, 350], 20), ([0, 90, 180], 180), ([5], 0), ([], 0), ([0, 120, 240], 240)],
)
def test_the_spread_of_directions_is_the_smallest_sector_with_all(degrees, expected):
    angles = np.radians(degrees)
    velocities = 0.3 * np.array([np.cos(angles), np.sin(angles)])
    at_rest = np.zeros((2, 1))

    assert spread(*np.hstack([velocities, at_rest])) == pytest.approx(np.radians(expected))


def test_velocities_that_converge_have_a_rate_and_keep_their_mean():
    t = np.arange(0, 201) / 10
    gaps = 0.1 * np.exp(-0.4 * t)
    vx = np.column_stack([0.2 + gaps, 0.2 - gaps]).ravel()
    commands = Commands(np.repeat(t, 2), np.tile([1, 2], len(t)), vx, 0.0 * vx)
    fleet = table((t, 0, 0), (t, 1, 0))
    run = Run(fleet, references=References('alignment', {}), commands=commands)

    found = run.metrics()['alignment']

    assert found.convergence_rate_1_s == pytest.approx(0.4)
    assert found.disagreement_at_start_m_s == pytest.approx(0.1)
    assert found.final_mean_vx_m_s == pytest.approx(0.2)
    assert found.spread_of_directions_at_end_rad == 0.0


def test_a_law_that_aligns_has_its_metrics_lines_and_plot():
    run = simulate('velocity_alignment', 3, 20.0)

    assert 'disagreement of velocities: ' in str(run.metrics())
    assert 'centre at the end' not in str(run.metrics())
    assert run.plot('errors').axes[0].get_title('left') == 'Alignment error'
    assert 'alignment' not in simulate('velocity_alignment', 1, 2.0).metrics()
