import math

import numpy as np
import pytest

from setcmas_tools import simulate
from setcmas_tools.measures.safety_metrics import (
    fleet_filtering,
    fleet_safety,
    fleet_separation,
    obstacle_distance,
)
from setcmas_tools.run.fleet_motion import fleet_table
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import RunInfo
from setcmas_tools.run.run_records import Commands, FilteredCommands, SafetyRecord

FLEET = fleet_table([[0.0, 1, 0, 0, 0, 0, 0]])


def run_with(verdicts):
    """Return a run of two robots with the verdicts of each period of 0.2 s, shape (C, 2)."""
    count = len(verdicts)
    t, robot = np.repeat(0.2 * np.arange(count), 2), np.tile([1, 2], count)
    zeros = np.zeros(2 * count)
    return Run(FLEET, FilteredCommands(t, robot, *[zeros] * 4, np.array(verdicts).ravel()))


def test_times_are_those_of_each_robot():
    found = fleet_filtering(run_with([[0, 1], [1, 1], [1, 1], [2, 2]]))

    assert found.overruled_s == {1: 0.6, 2: 0.8}
    assert found.lines == ['safety filter: no solution in 1 step, robots stopped']


def test_a_run_without_a_filter_has_none():
    zero = np.zeros(1)
    assert fleet_filtering(Run(FLEET, Commands(zero, zero.astype(int), zero, zero))) is None


LAB = {'arena': [-1.0, 1.0, -1.0, 1.0], 'min_separation': 0.5, 'duration': 4}


def run_with_of_safety(safety, **parameters):
    """Robot 1 drives from (-2, 0) to (2, 0) in 4 s and on; robot 2 stands at (0, 0.3)."""
    t = np.arange(51) / 10
    rows = [(s, 1, s - 2, 0, 0, 1, 0) for s in t] + [(s, 2, 0, 0.3, 0, 0, 0) for s in t]
    return Run(fleet_table(rows), safety=safety, info=RunInfo(scenario=parameters))


def test_stops_and_times_are_those_between_the_start_and_the_end():
    states = ['paused', 'moving', 'stopped', 'moving', 'moving', 'paused']
    rows = [(k - 1.0, 1, state, k in (0, 2, 3)) for k, state in enumerate(states)]
    rows += [(k - 1.0, 2, 'moving', False) for k in range(6)]
    measured = fleet_safety(
        run_with_of_safety(SafetyRecord.in_order(*zip(*rows, strict=True)), **LAB)
    )
    # The pause before the start does not count; robot 1 is outside until 1 s and from 3 s on.
    assert (measured.stops, measured.stopped_s, measured.overruled_s) == (2, 1.0, 2.0)
    assert measured.outside_arena_s == pytest.approx(3.0, abs=0.15)
    assert measured.too_near_s == pytest.approx(0.8, abs=0.15)
    assert measured.lines[0].startswith(
        'safety: 2 stops, stopped 1.0 s, limited or paused 2.0 s, '
    )


def test_a_simulation_has_no_safety_and_an_unknown_lab_no_arena():
    record = SafetyRecord.in_order([0.0], [1], ['moving'], [False])
    assert fleet_safety(run_with_of_safety(None, **LAB)) is None
    assert [*fleet_safety(run_with_of_safety(record)).values()] == [0, 0.0, 0.0, None, None]


AT_EACH_OTHER = 'def control(robotNo, nbRobots, poses, t):\n    return 3 - 2 * robotNo, 0\n'


@pytest.mark.parametrize(('model', 'size'), [('unicycle', 0.15), ('car', 0.41), ('1:car', 0.28)])
def test_robots_that_drive_through_each_other_touch_by_the_size_of_their_model(
    tmp_path, model, size
):
    law = tmp_path / 'law.py'
    law.write_text(AT_EACH_OTHER)
    start = [[-1, 1], [0, 0], [0, math.pi]]  # 2 m apart, and 1 m/s nearer
    found = simulate(law, 2, 4, poses=start, model=model).metrics()['separation']

    ((first, second, t),) = found.first_collisions
    assert (first, second, found.pairs_that_touched) == (1, 2, 1)
    assert 2 - t == pytest.approx(size, abs=0.05)
    assert f'collisions: robots 1 and 2 touched at {t:.1f} s' in found.lines


def test_robots_that_pass_between_two_samples_touch_and_others_do_not():
    t = np.arange(3) / 10
    rows = [(s, 1, 20 * s - 1, 0, 0, 20, 0) for s in t]
    rows += [(s, 2, 0.05, 0, 0, 0, 0) for s in t] + [(s, 3, 0, 0.5, 0, 0, 0) for s in t]
    found = fleet_separation(Run(fleet_table(rows)))

    assert found.first_collisions == [(1, 2, pytest.approx(0.0525, abs=0.01))]


def test_collisions_are_counted_and_the_first_are_listed():
    found = simulate('consensus', 8, 20).metrics()['separation']

    assert found.pairs_that_touched == 28
    assert len(found.first_collisions) == 3
    assert found.lines[-1].endswith(', 27 more pairs later')


@pytest.mark.parametrize(
    ('obstacles', 'least', 'robot', 'touched'),
    [
        ('disc 0 -1.5 1', 0.5, 1, False),
        ('disc 5 0 1; disc 0 0.5 0.15', 0.05, 2, True),
        ('polygon -1 1.3 1 1.3 0 2', 1.0, 2, False),
        ('polygon 0.5 -0.5 1.5 -0.5 1.5 0.5 0.5 0.5', 0.0, 1, True),
    ],
)
def test_the_least_distance_from_an_obstacle_is_that_of_the_nearest_robot(
    obstacles, least, robot, touched
):
    found = obstacle_distance(run_with_of_safety(None, obstacles=obstacles))

    assert found.least_obstacle_distance_m == pytest.approx(least)
    assert (found.least_obstacle_distance_robot, found.touched) == (robot, touched)
    assert ('which touched it' in found.lines[0]) == touched


def test_a_run_without_obstacles_has_no_distance_from_one():
    assert obstacle_distance(run_with_of_safety(None)) is None
