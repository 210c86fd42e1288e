import math

import numpy as np
import pytest

from setcmas_expe.guard.lidar import (
    BESIDE_WHEELS_M,
    BRAKING_M_S2,
    FRONT_M,
    SILENT_AFTER_S,
    braking_distance,
    clearance,
)

STEP = math.radians(1.0)
WHEELS_M = 0.16
FREE = np.full(360, math.inf)


def scan(*things):
    """Return the ranges of a turn that sees things: middle in degrees, number of points, m."""
    ranges = FREE.copy()
    for middle, points, distance in things:
        ranges[np.arange(middle - points // 2, middle + points - points // 2) % 360] = distance
    return ranges


@pytest.mark.parametrize(
    ('things', 'V', 'nearest'),
    [
        ([], 0.2, math.inf),
        ([(0, 9, 0.3)], 0.2, 0.3),
        ([(0, 9, 0.3)], -0.2, math.inf),
        ([(180, 9, 0.3)], -0.2, 0.3),
        ([(0, 9, 0.3)], 0.0, math.inf),  # it only turns
        ([(90, 9, 0.15)], 0.2, math.inf),  # beside it
        ([(0, 2, 0.3)], 0.2, math.inf),  # dust
        ([(0, 9, 0.5), (10, 9, 0.25)], 0.2, 0.25),
        ([(0, 9, 0.0)], 0.2, math.inf),  # no measurement: too far or too near
        ([(0, 9, -math.inf)], 0.2, 0.0),  # too near
        ([(0, 9, -math.inf)], -0.2, math.inf),
    ],
)
def test_what_is_in_the_way_is_near_in_the_direction_of_travel(things, V, nearest):
    assert clearance(scan(*things), 0.0, STEP, V, WHEELS_M) == pytest.approx(
        nearest, rel=0.03, abs=0.01
    )


def test_the_way_is_a_strip_as_wide_as_the_robot():
    beside = math.degrees(math.asin((0.5 * WHEELS_M + BESIDE_WHEELS_M) / 0.4))
    assert clearance(scan((round(beside) - 4, 5, 0.4)), 0.0, STEP, 0.2, WHEELS_M) < 0.4
    assert clearance(scan((round(beside) + 4, 5, 0.4)), 0.0, STEP, 0.2, WHEELS_M) == math.inf


@pytest.mark.parametrize('V', [0.2, 0.0])
@pytest.mark.parametrize(
    ('ranges', 'first', 'step'),
    [
        ([], 0.0, STEP),
        ([0.0] * 360, 0.0, STEP),
        ([math.nan] * 360, 0.0, STEP),
        (FREE, math.nan, STEP),
        (FREE, 0.0, math.inf),
    ],
)
def test_a_lidar_that_sees_nothing_is_blind(ranges, first, step, V):
    assert math.isnan(clearance(ranges, first, step, V, WHEELS_M))


def test_a_lidar_that_falls_silent_is_noticed_within_what_the_braking_distance_allows():
    V = 0.26
    rolls = V * SILENT_AFTER_S + V * V / (2.0 * BRAKING_M_S2)
    assert braking_distance(V) - rolls >= FRONT_M


@pytest.mark.parametrize(('V', 'metres'), [(0.0, 0.19), (0.2, 0.278), (-0.2, 0.278)])
def test_a_fast_robot_needs_more_room(V, metres):
    assert braking_distance(V) == pytest.approx(metres)
