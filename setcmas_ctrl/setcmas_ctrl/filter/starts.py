"""Starts of robots that the safety filter could not make safe: outside the arena, in obstacles."""

from __future__ import annotations

from setcmas_ctrl.filter.options import FilterOptions
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.world.arena import Arena
from setcmas_simu.world.obstacles import Obstacles


def check_starts(options: FilterOptions, poses: Floats) -> None:
    """See that the filter, if it is on, finds robots where they may be.

    Args:
        options: Those of the filter.
        poses: Start poses of the fleet, shape (3, N).

    Raises:
        SetcmasError: A robot starts outside the arena or inside an obstacle.
    """
    if not options.is_on:
        return
    obstacles = Obstacles.of(options.obstacles or '')
    for robot, (x, y) in enumerate(poses[:2].T.tolist(), start=1):
        at = f'robot {robot} starts at ({x:g}, {y:g}) m,'
        if options.arena and Arena(*options.arena).distance(x, y):
            raise SetcmasError(
                f'{at} outside the arena; give it a --pose inside, or a larger --arena'
            )
        if obstacles.contain(x, y):
            raise SetcmasError(f'{at} inside an obstacle; give it another --pose')
