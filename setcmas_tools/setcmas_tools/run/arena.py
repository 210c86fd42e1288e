"""Arena and obstacles of a run, as its record tells."""

from __future__ import annotations

from contextlib import suppress

from setcmas_simu.errors import SetcmasError
from setcmas_simu.world.arena import Arena
from setcmas_simu.world.obstacles import Obstacles
from setcmas_tools.run.run import Run


def arena_of(run: Run) -> Arena | None:
    """Return the arena of a run; None if its record tells of none."""
    with suppress(TypeError, ValueError):
        return Arena(*map(float, run.parameters.get('arena') or ()))
    return None


def obstacles_of(run: Run) -> Obstacles:
    """Return the obstacles of a run; none if its record tells of none."""
    with suppress(SetcmasError):
        return Obstacles.of(str(run.parameters.get('obstacles') or ''))
    return Obstacles()
