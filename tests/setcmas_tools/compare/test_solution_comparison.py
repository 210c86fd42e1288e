"""Distances of paths whatever the timing."""

import numpy as np
import pytest

from setcmas_tools.compare.solution_comparison import frechet_distance

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
