"""Arena, obstacles and models of the robots of a run, as its record tells."""

from __future__ import annotations

from contextlib import suppress

from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.arena import Arena, Obstacles
from setcmas_simu.robots.models import UNICYCLE, model_names
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


def models_of(run: Run) -> dict[int, str]:
    """Return the model of each robot of a run; unicycles if its record tells of none."""
    names = [UNICYCLE] * max(run.robots)
    with suppress(SetcmasError):
        names = model_names(run.parameters.get('model'), max(run.robots))
    return {robot: names[robot - 1] for robot in run.robots}
