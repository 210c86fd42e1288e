"""Points for numbers, up to and beyond what is wanted."""

import math

import pytest

from setcmas_tools.grade.criteria import Bounds, Criterion

AT_MOST = Bounds(high=0.1, none_above=0.5)
BELOW = Bounds(high=0.1, strict=True)
AT_LEAST = Bounds(low=6, none_below=1)
BETWEEN = Bounds(low=2, high=4, none_below=1, none_above=6)


@pytest.mark.parametrize(
    ('bounds', 'number', 'points'),
    [
        (AT_MOST, 0.1, 3),
        (AT_MOST, 0.3, 1.5),
        (AT_MOST, 0.10001, 2.99),  # all points are for what is wanted, not for nearly that
        (AT_MOST, 0.5, 0),
        (AT_MOST, math.inf, 0),
        (AT_MOST, None, 0),
        (AT_MOST, math.nan, 0),
        (BELOW, 0.1, 0),
        (BELOW, 0.0999, 3),
        (AT_LEAST, 7, 3),
        (AT_LEAST, 3, 1.2),
        (AT_LEAST, -5, 0),
        (BETWEEN, 2, 3),
        (BETWEEN, 1.5, 1.5),
        (BETWEEN, 5, 1.5),
        (BETWEEN, 7, 0),
    ],
)
def test_points_are_linear_between_two_thresholds(bounds, number, points):
    assert Criterion('', 'disagreement', 3, bounds).points_for(number) == points
