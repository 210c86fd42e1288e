"""Points for numbers, up to and beyond what is wanted."""

import math

import pytest

from setcmas_tools.grade.criteria import Bounds, Criterion, points_text, rounded

AT_MOST = Bounds(high=0.1, none_above=0.5)
AT_LEAST = Bounds(low=6, none_below=1)
BETWEEN = Bounds(low=2, high=4, none_below=1, none_above=6)


@pytest.mark.parametrize(
    ('bounds', 'number', 'points'),
    [
        (AT_MOST, 0.1, 3),
        (AT_MOST, 0.3, 1.5),
        (AT_MOST, 0.10001, 3),
        (AT_MOST, 0.10167, 2.99),
        (AT_MOST, 0.5, 0),
        (AT_MOST, math.inf, 0),
        (AT_MOST, None, 0),
        (AT_MOST, math.nan, 0),
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


@pytest.mark.parametrize(
    ('points', 'text'),
    [
        (9.995, '10'),
        (2.9999, '3'),
        (0.125, '0.13'),
        (1 / 3, '0.33'),
        (-0.125, '-0.13'),
        (-0.001, '0'),
        (12345.675, '12345.68'),
        (100, '100'),
    ],
)
def test_points_are_rounded_as_people_do(points, text):
    assert points_text(points) == text
    assert rounded(points) == float(text)
