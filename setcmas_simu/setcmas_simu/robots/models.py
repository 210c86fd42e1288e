"""Robot models by name or script, one for each robot: `--model 1:burger,2-4:omnidirectional`."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from setcmas_simu.doors import Door, MisfitError
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import format_robots
from setcmas_simu.fleet.per_robot import check_in_fleet, is_per_robot, parse_per_robot
from setcmas_simu.robots.model import RobotModel
from setcmas_simu.robots.shape import Shape
from setcmas_simu.robots.unicycle import Unicycle
from setcmas_simu.robots.velocity_limits import limits_named

UNICYCLE = 'unicycle'
"""The model of robots for which none is named."""

NO_LIMITS = 'ideal'

LoadScript = Callable[[Path, int, Callable[[str], None]], RobotModel]
"""Loads a robot script for a robot; the last argument shows messages about its failures."""


def _checked(thing: Any) -> RobotModel:
    if isinstance(thing, type):
        raise MisfitError(f'it is a class; it must be an object of it, such as {thing.__name__}()')
    if not isinstance(thing, RobotModel):
        raise MisfitError(f'it is a {type(thing).__name__}; it must be a RobotModel')
    return thing


def _callable(thing: Any) -> LoadScript:
    if not callable(thing):
        raise MisfitError(f'it is a {type(thing).__name__}; it must be a function')
    load: LoadScript = thing
    return load


MODELS = Door('setcmas.robot_models', 'robot model', _checked)
SCRIPT_LOADERS = Door('setcmas.robot_scripts', 'loader of robot scripts', _callable)
"""What runs a robot script. It comes with the control scripts, whose loader it uses."""


def is_script(name: str) -> bool:
    """Return whether a name of a model means a script, not a shipped model or a plugin."""
    return name.endswith('.py')


def model_names(text: str | None, nb_robots: int) -> list[str]:
    """Return the name of each robot's model.

    Args:
        text: A name or a script for all robots, or for some: '1:burger,2-4:my_robot.py'; the
            others are unicycles, as all are without a text.
        nb_robots: Size of the fleet.

    Raises:
        SetcmasError: The text is malformed, or names robots that are not in the fleet.
    """
    if text is None or not is_per_robot(text):
        return [text or UNICYCLE] * nb_robots
    named = parse_per_robot(text, '--model')
    check_in_fleet(named, nb_robots, '--model')
    return [named.get(robot, UNICYCLE) for robot in range(1, nb_robots + 1)]


def shape_of(name: str) -> Shape:
    """Return what robots of a model look like; those of scripts and unknown ones as unicycles."""
    with contextlib.suppress(SetcmasError):
        if not is_script(name):
            return MODELS.get(name).shape
    return Unicycle.shape


def fastest(text: str | None, nb_robots: int, limits: str) -> float | None:
    """Return the largest speed in m/s that a fleet can reach; None where that is not known.

    Args:
        text: What `--model` says.
        nb_robots: Size of the fleet.
        limits: Those of unicycles.
    """
    with contextlib.suppress(SetcmasError):
        unicycle = limits_named(limits).V_max
        return max(
            unicycle
            if name == UNICYCLE
            else math.inf
            if is_script(name)
            else MODELS.get(name).V_max
            for name in model_names(text, nb_robots)
        )
    return None


def check_models(names: Sequence[str], limits: str) -> None:
    """See that models exist, without loading them, and that limits are for unicycles only.

    Raises:
        SetcmasError: There is no such model, or robots of another model would have limits.
    """
    for name in dict.fromkeys(names):
        if is_script(name):
            _check_file(Path(name))
        elif name != UNICYCLE:
            MODELS.offer(name)
    others = [robot for robot, name in enumerate(names, start=1) if name != UNICYCLE]
    if others and limits != NO_LIMITS:
        robots = f'robot{"s" * (len(others) > 1)} {format_robots(others)}'
        raise SetcmasError(
            f"--limits '{limits}' is for unicycles; --model makes {robots} "
            f'{", ".join(dict.fromkeys(names[robot - 1] for robot in others))}, with limits of '
            'their own: leave one of the two out'
        )


def _check_file(path: Path) -> None:
    if not path.is_file():
        raise SetcmasError(f"robot script '{path}' was not found; write one: setcmas new --robot")


def absolute(names: Sequence[str]) -> list[str]:
    """Return names of models, scripts with absolute paths: another script may change folders."""
    return [str(Path(name).absolute()) if is_script(name) else name for name in names]


def robot_models(
    names: Sequence[str],
    robots: Sequence[int],
    limits: str = NO_LIMITS,
    warn: Callable[[str], None] = print,
) -> list[RobotModel]:
    """Return the model of each robot; a script is loaded for each of its robots.

    Args:
        names: The name of each robot's model.
        robots: The robots' numbers, as many.
        limits: Those of unicycles, 'ideal' for none.
        warn: Shows messages about robot scripts that fail.

    Raises:
        SetcmasError: There is no such model, or a script cannot be loaded.
    """
    unicycle = Unicycle(limits_named(limits))
    models: list[RobotModel] = []
    for name, robot in zip(names, robots, strict=True):
        if name == UNICYCLE:
            models.append(unicycle)
        elif is_script(name):
            models.append(SCRIPT_LOADERS.get('python')(Path(name), robot, warn))
        else:
            models.append(MODELS.get(name))
    return models
