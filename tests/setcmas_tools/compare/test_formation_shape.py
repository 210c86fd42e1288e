"""Shapes of formations, whichever robot has which place."""

from itertools import permutations

import numpy as np
import pytest

from setcmas_tools.compare.formation_shape import assignment, shape_distance

RANDOM = np.random.default_rng(1)
TURN = np.array([[0.6, -0.8], [0.8, 0.6]])


def polygon(n, radius=2.0):
    angles = 2 * np.pi * np.arange(n) / n
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


@pytest.mark.parametrize('n', [1, 2, 3, 8])
def test_a_polygon_is_the_same_with_its_places_shifted_turned_and_moved(n):
    for places in (np.roll(polygon(n), 1, 0), RANDOM.permutation(polygon(n)) @ TURN + [5, -3]):
        assert shape_distance(places, polygon(n)) < 1e-9
    assert shape_distance(polygon(n, 2.2), polygon(n)) == pytest.approx(0.2 if n > 1 else 0)


def test_any_formation_is_found_again_but_not_its_mirror_image():
    formation = RANDOM.random((8, 2))

    assert shape_distance(RANDOM.permutation(formation) @ TURN + 1, formation) < 1e-9
    assert shape_distance(formation * [1, -1], formation) > 0.05
    assert shape_distance(polygon(4), np.ones((4, 2))) == pytest.approx(2)


@pytest.mark.parametrize('n', [1, 2, 5])
def test_an_assignment_costs_least(n):
    for costs in RANDOM.random((20, n, n)):
        found = costs[np.arange(n), assignment(costs)].sum()

        assert found == pytest.approx(
            min(costs[np.arange(n), [*p]].sum() for p in permutations(range(n)))
        )
