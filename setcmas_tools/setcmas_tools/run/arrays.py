"""Arrays of a run whose robots have common times, as simulated ones have."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_tools.records.tables import RunTables


class RunArrays:
    """What happened in a run, as arrays with a column for each robot."""

    tables: RunTables

    @property
    def t(self) -> Floats:
        """Times of the robots' states in s, shape (K,); of runs with common times (simulated)."""
        return self._stacked[0]

    @property
    def poses(self) -> Floats:
        """Rows x, y in m and theta in rad, shape (K, 3, N), at the times t."""
        return self._stacked[1]

    @property
    def V(self) -> Floats:  # noqa: N802 (the field's name)
        """Forward speeds over the step that led to each state in m/s, shape (K, N)."""
        return self._stacked[2]

    @property
    def omega(self) -> Floats:
        """Turn rates over that step in rad/s, shape (K, N)."""
        return self._stacked[3]

    @cached_property
    def _stacked(self) -> tuple[Floats, Floats, Floats, Floats]:
        stacked = self.tables.fleet.stacked()
        if stacked is None:
            raise SetcmasError(
                "the robots of this run have states at times of their own: take run['tb3_1'].t "
                'and so on, or run.grid(), which interpolates'
            )
        t, x, y, theta, v, omega = stacked
        return t[:, 0], np.stack([x, y, theta], axis=1), v, omega

    @property
    def control_t(self) -> Floats:
        """Times at which the control laws were called in s, shape (C,), of simulated runs."""
        return self._stacked_commands[0]

    @property
    def velocities(self) -> Floats:
        """What they asked for, after saturation: rows vx, vy in m/s, shape (C, 2, N)."""
        return self._stacked_commands[1]

    @cached_property
    def _stacked_commands(self) -> tuple[Floats, Floats]:
        commands = self.tables.commands
        found = commands.stacked() if commands else None
        if found is None:
            raise SetcmasError(
                'the robots of this run have commands at times of their own, or none that are '
                'known: take run.commands.of(1) and so on'
            )
        return found
