import math

import numpy as np
import pytest
from metrics_runs import T, numbers, table, write_run

from setcmas_simu.errors import SetcmasError
from setcmas_tools.metrics.compute import compute, measure
from setcmas_tools.metrics.yaml_file import as_dict
from setcmas_tools.run.references import References


def test_position_errors_of_a_formation():
    places = np.array([[-1.0, 0.0], [0.0, 1.0]])
    late = np.where(T < 10, 1.0, 0.0)
    fleet = table((T, 0.1 * T, 0), (T, 0.1 * T - 0.7, 0.4), (T, 0.1 * T, 1 + late))

    errors = measure(fleet, goal=References('formation', places=places)).formation

    assert errors.position_error_final_m == pytest.approx({2: 0.5, 3: 0.0})
    assert errors.position_error_rms_last_quarter_m == pytest.approx({2: 0.5, 3: 0.0})
    assert errors.fleet_position_error_rms_last_quarter_m == pytest.approx(0.5 / math.sqrt(2))


def test_distance_errors_of_a_formation():
    fleet = table((T, 0, 0), (T, 3, 0), (T, 0, 4))

    errors = measure(fleet, goal=References('distances', distance=3.0)).distances

    assert errors.distance_errors_final_m == pytest.approx({'1-2': 0.0, '1-3': 1.0, '2-3': 2.0})
    assert errors.distance_error_final_rms_m == pytest.approx(math.sqrt(5 / 3))
    assert errors.distance_error_rms_last_quarter_m == pytest.approx(math.sqrt(5 / 3))
    assert errors.distance_error_final_largest_m == pytest.approx(2.0)


def test_tracking_errors():
    radius = np.where(T < 10, 2.5, 2.1)
    fleet = table((T, radius * np.cos(0.2 * T), radius * np.sin(0.2 * T)))

    errors = measure(fleet, goal=References('tracking', radius=2.0, rate=0.2)).tracking

    whole = math.sqrt((100 * 0.5**2 + 101 * 0.1**2) / 201)
    assert errors.tracking_error_rms_m == pytest.approx({1: whole})
    assert errors.tracking_error_rms_second_half_m == pytest.approx({1: 0.1})
    assert errors.fleet_tracking_error_rms_m == pytest.approx(whole)


def test_waypoints_of_a_script_of_ones_own(tmp_path):
    # At 0.1 m/s along x the distance to (1, 0) is below 0.055 m from 9.5 s on.
    script = tmp_path / 'mine.py'
    script.write_text('WPL = [[1, 0], [1.5, 0]]\nREACHED = 0.055\ndef control(*_): return 0, 0\n')
    fleet = table((T, 0.1 * T, 0), (T, 3 - 0.1 * T, 0))
    run = write_run(tmp_path / 'run', fleet, algo='mine', script=str(script))

    visits = compute(run, task='waypoints').waypoints

    assert visits.waypoints_m == [[1.0, 0.0], [1.5, 0.0]]
    assert visits.reached_within_m == 0.055
    assert visits.reached_at_s == {1: [9.5, 14.5], 2: [19.5]}
    assert compute(run).task is None


def test_a_list_of_waypoints_is_gone_through_again():
    goal = References('waypoints', waypoints=np.array([[1.0, 0], [0, 0]]), reached=0.01)
    x = np.select([T < 3, T < 6, T < 7], [0, 1, 0], 1)

    assert measure(table((T, x, 0)), goal=goal).waypoints.reached_at_s == {1: [3.0, 6.0, 7.0]}


@pytest.mark.parametrize(
    ('script', 'task', 'part'),
    [
        ('nav_wp.py', 'waypoints', 'waypoints'),
        ('leader_follower_formation.py', 'formation', 'formation'),
        ('leader_follower_formation.py', 'formation', 'waypoints'),
        ('leader_follower_distance_formation.py', 'distances', 'distances'),
        ('traj_tracking.py', 'tracking', 'tracking'),
        ('consensus.py', 'consensus', 'consensus'),
    ],
)
@pytest.mark.parametrize('nb_robots', [1, 3, 12])
def test_the_task_is_that_of_the_built_in_law_wherever_it_was_installed(
    tmp_path, script, task, part, nb_robots
):
    fleet = table(*((T, 0.1 * T, 2.0 * i) for i in range(nb_robots)))
    place = f'C:\\venv\\setcmas_ctrl\\algorithms\\{script}'
    metrics = compute(write_run(tmp_path, fleet, algo=script[:-3], script=place))

    assert metrics.task == task
    needs_two = part in ('formation', 'distances', 'consensus')
    assert (getattr(metrics, part) is None) == (needs_two and nb_robots == 1)
    assert all(map(math.isfinite, numbers(as_dict(metrics))))


def test_a_script_of_ones_own_named_like_a_built_in_is_not_that(tmp_path):
    run = write_run(tmp_path, table((T, 0, 0)), algo='nav_wp', script='/home/me/nav_wp.py')

    assert compute(run).task is None


@pytest.mark.parametrize(
    ('script', 'task', 'message'),
    [
        ('', 'waypoints', 'defines no WPL'),
        ('WPL = [1, 2]', 'waypoints', r"WPL is '\[1, 2\]'; accepted are points"),
        ('PLACES = [(1, 0)]', 'formation', '1 places for 2 followers'),
        ('def places_of(n): return 1 / 0', 'formation', 'ZeroDivisionError'),
        ('D = "far"', 'distances', "D is 'far'; accepted is a number"),
        ('R = 2', 'tracking', 'defines no W'),
        ('', 'dance', "task 'dance' is unknown; accepted are consensus"),
    ],
)
def test_numbers_that_a_script_does_not_define(tmp_path, script, task, message):
    path = tmp_path / 'mine.py'
    path.write_text(f'{script}\ndef control(*_): return 0, 0\n')
    run = write_run(tmp_path / 'run', table((T, 0, 0), (T, 1, 0), (T, 2, 0)))

    with pytest.raises(SetcmasError, match=message):
        compute(run, task=task, algo=str(path))


def test_a_task_without_a_script(tmp_path):
    with pytest.raises(SetcmasError, match='name it with --algo'):
        compute(write_run(tmp_path, table((T, 0, 0))), task='tracking')
