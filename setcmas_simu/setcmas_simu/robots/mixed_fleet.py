"""A fleet of robots of several models, as one model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.robots.model import RobotModel


def fleet_model(models: Sequence[RobotModel]) -> RobotModel:
    """Return one model for a fleet, from the model of each robot."""
    first = models[0]
    return first if all(model is first for model in models) else MixedFleet(models)


class MixedFleet(RobotModel):
    """Robots of several models; robots of the same model move together."""

    def __init__(self, models: Sequence[RobotModel]) -> None:
        """Take the model of each robot."""
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

    def command(self, velocities: Floats, poses: Floats, komega: float) -> Floats:
        """Return the commands (3, N) that give robots their velocities (2, N)."""
        commands = np.empty(poses.shape)
        for model, columns in self._groups:
            commands[:, columns] = model.command(velocities[:, columns], poses[:, columns], komega)
        return commands

    def step(self, states: Floats, commands: Floats, Ts: float) -> Floats:
        """Return the states one period later."""
        later = np.zeros_like(states)
        for (model, columns), size in zip(self._groups, self._sizes, strict=True):
            own = states[:size, columns]
            later[:size, columns] = model.step(own, commands[:, columns], Ts)
        return later
