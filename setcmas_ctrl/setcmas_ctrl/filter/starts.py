"""Starts of robots that the safety filter could not make safe."""

from __future__ import annotations

import numpy as np

from setcmas_ctrl.filter.options import SEPARATION_M, FilterOptions
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.world.arena import Arena
from setcmas_simu.world.obstacles import Obstacles

_ROUNDING_M = 1e-6


def check_starts(options: FilterOptions, poses: Floats) -> None:
    """See that the filter, if it is on, finds robots where they may be.

    Args:
        options: Those of the filter.
        poses: Start poses of the fleet, shape (3, N).

    Raises:
        SetcmasError: A robot starts outside the arena, inside an obstacle or too near another.
    """
    if not options.is_on:
        return
    obstacles = Obstacles.of(options.obstacles or '')
    for robot, (x, y) in enumerate(poses[:2].T.tolist(), start=1):
        at = f'robot {robot} starts at ({x:g}, {y:g}) m,'
        if options.arena and Arena(*options.arena).distance(x, y):
            raise SetcmasError(f'{at} outside the arena; give it another pose, or a larger arena')
        if obstacles.contain(x, y):
            raise SetcmasError(f'{at} inside an obstacle; give it another pose')
    _check_distances(poses, options.min_separation or SEPARATION_M)


def _check_distances(poses: Floats, separation: float) -> None:
    i, j = np.triu_indices(poses.shape[1], 1)
    distances = np.hypot(*(poses[:2, j] - poses[:2, i]))
    for pair in np.flatnonzero(distances < separation - _ROUNDING_M)[:1]:
        raise SetcmasError(
            f'robots {i[pair] + 1} and {j[pair] + 1} start {distances[pair]:.3g} m apart; with '
            f'the safety filter it must be at least {separation:g} m: give them other poses, or '
            'a smaller min_separation'
        )
