"""Robot model of a plugin: a failure stops its robots and names package and line."""

from __future__ import annotations

import inspect
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.plugins import Plugin
from setcmas_simu.robots.model import TWIST, RobotModel


class PluginModel(RobotModel):
    """A model of a plugin, whose results are checked."""

    def __init__(self, model: RobotModel, plugin: Plugin, warn: Callable[[str], None]) -> None:
        """Take a model and its plugin; `warn` shows a message about its first failure."""
        self.shape, self.V_max = model.shape, model.V_max
        self.motion, self.limits = model.motion, model.limits
        self.failed = False
        self._model = model
        self._name = f'robot model {plugin.title}'
        self._warn = warn

    def start(self, poses: Floats) -> Floats:
        """Return the states (6+, N) of robots at rest at poses (3, N), or raise SetcmasError."""
        states, reason = self._result('start', (None, poses.shape[1]), poses)
        if reason:
            raise SetcmasError(f'{self._name}: {reason}')
        return states

    def command(self, velocities: Floats, poses: Floats, komega: float) -> Floats:
        """Return the commands (3, N) for velocities (2, N); zero if the model fails."""
        commands, reason = self._result('command', poses.shape, velocities, poses, komega)
        return self._or_fail(commands, reason, np.zeros(poses.shape))

    def step(self, states: Floats, commands: Floats, Ts: float) -> Floats:
        """Return the states one period later; robots stop if the model fails."""
        later, reason = self._result('step', states.shape, states, commands, Ts)
        rest: Floats = states.copy()
        rest[TWIST] = 0.0
        return self._or_fail(later, reason, rest)

    def _result(
        self, name: str, shape: tuple[int | None, ...], *arguments: Any
    ) -> tuple[Floats, str]:
        """Return the result of a method, and why it cannot be used; '' if it can."""
        method = getattr(self._model, name)
        try:
            result = np.asarray(method(*arguments), dtype=float)
        except Exception as error:  # a plugin may raise anything
            last = traceback.extract_tb(error.__traceback__)[-1]
            text = ' '.join(f'{type(error).__name__}: {error}'.split())
            return np.empty(0), f'{text} ({Path(last.filename).name}, line {last.lineno})'
        code = getattr(inspect.unwrap(method), '__code__', None)
        place = f' ({Path(code.co_filename).name}, line {code.co_firstlineno})' if code else ''
        rows, columns = shape
        if (
            result.ndim != 2
            or result.shape[1] != columns
            or result.shape[0] != (rows or max(TWIST.stop, len(result)))
        ):
            wanted = f'({rows or "6 or more"}, {columns})'
            return result, f'{name} returned an array {result.shape}, not {wanted}{place}'
        if not np.isfinite(result).all():
            return result, f'{name} returned NaN or inf{place}'
        return result, ''

    def _or_fail(self, result: Floats, reason: str, rest: Floats) -> Floats:
        if not reason:
            return result
        if not self.failed:
            self.failed = True
            self._warn(f'{self._name}: {reason}; its robots stop')
        return rest
