"""Robot models by name or file, one for each robot: `--model 1:burger,2-4:omnidirectional`."""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import check_in_fleet, is_per_robot, parse_per_robot, robots_in_words
from setcmas_simu.plugins import InvalidPluginError, PluginGroup
from setcmas_simu.robots.identified_robot import ENDINGS, read_model_file
from setcmas_simu.robots.model import Motion, RobotModel, Shape, limits_named
from setcmas_simu.robots.unicycle import Unicycle

_SYMBOL_SIDE = 1.587


def fleet_model(models: Sequence[RobotModel]) -> RobotModel:
    """Return one model for a fleet, from the model of each robot."""
    first = models[0]
    return first if all(model is first for model in models) else MixedFleet(models)


class MixedFleet(RobotModel):
    """Robots of several models; robots of the same model move together."""

    def __init__(self, models: Sequence[RobotModel]) -> None:
        distinct = {id(model): model for model in models}
        self._groups = [
            (model, np.array([i for i, one in enumerate(models) if one is model]))
            for model in distinct.values()
        ]
        self.shape = models[0].shape
        self.V_max = max(model.V_max for model in models)
        self._sizes: list[int] = []

    def start(self, poses: Floats) -> Floats:
        """Return the states of robots at rest at poses (3, N)."""
        parts = [model.start(poses[:, columns]) for model, columns in self._groups]
        self._sizes = [len(part) for part in parts]
        states = np.zeros((max(self._sizes), poses.shape[1]))
        for (_, columns), part in zip(self._groups, parts, strict=True):
            states[: len(part), columns] = part
        return states

    def step(self, states: Floats, commands: Floats, Ts: float) -> Floats:
        """Return the states one period later."""
        later = np.zeros_like(states)
        for (model, columns), size in zip(self._groups, self._sizes, strict=True):
            own = states[:size, columns]
            later[:size, columns] = model.step(own, commands[:, columns], Ts)
        return later


UNICYCLE = 'unicycle'
"""Default model."""

NO_LIMITS = 'ideal'


def _checked(thing: Any) -> RobotModel:
    if isinstance(thing, type):
        raise InvalidPluginError(f'it is a class; it must be an instance, as {thing.__name__}()')
    if not isinstance(thing, RobotModel):
        raise InvalidPluginError(f'it is a {type(thing).__name__}; it must be a RobotModel')
    return thing


MODELS = PluginGroup('setcmas.robot_models', 'robot model', _checked)


def _robot_scripts() -> Any:
    """Return the class of robot scripts, which are loaded as a controller loads its scripts."""
    return importlib.import_module('setcmas_ctrl.robot_script').ScriptRobot


def is_script(name: str) -> bool:
    """Return whether a model name is a script."""
    return name.endswith('.py')


def is_file(name: str) -> bool:
    """Return whether a model name is a script or a model file, not a built-in model or plugin."""
    return is_script(name) or is_model_file(name)


def is_model_file(name: str) -> bool:
    """Return whether a model name is a model file."""
    return name.endswith(ENDINGS)


def model_names(text: str | None, nb_robots: int) -> list[str]:
    """Return the name of each robot's model, from a text such as '1:burger,2-4:my_robot.py'.

    A name, script or model file may be for all robots; robots without one are unicycles.

    Raises:
        SetcmasError: The text is malformed, or names a robot outside the fleet.
    """
    if text is None or not is_per_robot(text):
        return [text or UNICYCLE] * nb_robots
    named = parse_per_robot(text, '--model')
    check_in_fleet(named, nb_robots, '--model')
    return [named.get(robot, UNICYCLE) for robot in range(1, nb_robots + 1)]


def shape_of(name: str) -> Shape:
    """Return the shape of robots of a model; that of unicycles for scripts and unknown names."""
    return _model_or_unicycle(name).shape


def motion_of(name: str) -> Motion:
    """Return how robots of a model follow velocities; as unicycles for scripts."""
    return _model_or_unicycle(name).motion


def _model_or_unicycle(name: str) -> RobotModel:
    with contextlib.suppress(SetcmasError):
        if not (name == UNICYCLE or is_file(name)):  # plugins take time to find
            return MODELS.get(name)
    return Unicycle()


def fastest(text: str | None, nb_robots: int, limits: str) -> float | None:
    """Return the top speed of a fleet in m/s; None if unknown.

    `text` is the value of `--model`, `limits` names the limits of unicycles.
    """
    with contextlib.suppress(SetcmasError):
        names, robots = model_names(text, nb_robots), range(1, nb_robots + 1)
        # A script does not say how fast its robot is.
        models = _models(names, robots, limits, lambda *_: Unicycle())
        return max(model.V_max for model in models)
    return None


def check_models(names: Sequence[str], limits: str, robots: Sequence[int] | None = None) -> None:
    """Check that models exist, without loading scripts, and that limits are for unicycles only.

    `robots` has the numbers of the robots in the order of their models' names, by default from 1.

    Raises:
        SetcmasError: A model is unknown, or limits would apply to a robot of another model.
    """

    def existing(script: Path, _: int) -> RobotModel:
        if not script.is_file():
            raise SetcmasError(
                f"robot script '{script}' not found; write one with setcmas new --robot"
            )
        return Unicycle()

    numbers = robots or range(1, len(names) + 1)
    _models(names, numbers, limits, existing)
    others = {robot: name for robot, name in zip(numbers, names, strict=True) if name != UNICYCLE}
    if others and limits != NO_LIMITS:
        raise SetcmasError(
            f"limits '{limits}' is for unicycles, but the model makes "
            f'{robots_in_words(list(others))} {", ".join(dict.fromkeys(others.values()))}, which '
            'have limits of their own; remove one of the two options'
        )


def robot_models(
    names: Sequence[str],
    robots: Sequence[int],
    limits: str = NO_LIMITS,
    warn: Callable[[str], None] = print,
    on_call: Callable[[int, Path], object] = lambda *_: None,
) -> list[RobotModel]:
    """Return the model of each robot, from its name and number; each loads its own script.

    Limits are those of unicycles; `warn` shows messages about failing robot scripts, and `on_call`
    is called with robot and script before each call of one.

    Raises:
        SetcmasError: A model is unknown, or a script does not load.
    """
    return _models(
        names, robots, limits, lambda path, robot: _robot_scripts()(path, robot, warn, on_call)
    )


def _models(
    names: Sequence[str],
    robots: Sequence[int],
    limits: str,
    load: Callable[[Path, int], RobotModel],
) -> list[RobotModel]:
    """Return the model of each robot; `load` returns that of a script for a robot.

    Each model file is read once, so that robots can share its models.
    """
    unicycle = Unicycle(limits_named(limits))
    files = {name: read_model_file(Path(name)) for name in {*names} if is_model_file(name)}
    models: list[RobotModel] = []
    for name, robot in zip(names, robots, strict=True):
        if name == UNICYCLE:
            models.append(unicycle)
        elif is_script(name):
            models.append(load(Path(name), robot))
        elif name in files:
            models.append(files[name].robot(robot))
        else:
            models.append(MODELS.get(name))
    return models


def seed_scripts(names: Sequence[str], seed: int) -> None:
    """Seed the random numbers that the robot scripts among some models draw."""
    if any(map(is_script, names)):
        _robot_scripts().seed(seed)


def symbol(model: str) -> Floats:
    """Return a model's outline along the x axis, corners (K, 2), as large as a square of 1.587."""
    corners = np.array(shape_of(model).outline)
    scaled: Floats = corners * (_SYMBOL_SIDE / np.sqrt(np.prod(np.ptp(corners, axis=0))))
    return scaled
