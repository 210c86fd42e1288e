"""Commander: converts velocities of control laws to commands of their robots."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from setcmas_ctrl.control.control_options import GainOptions
from setcmas_ctrl.control.saturation import limited_rise, saturate
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.robots.model import IDEAL, RobotModel, VelocityLimits
from setcmas_simu.robots.models import fleet_model
from setcmas_simu.robots.unicycle import Unicycle


class Commanded(NamedTuple):
    """Commands of R robots.

    Attributes:
        wanted: Velocities of the laws after saturation: rows vx, vy in m/s, shape (2, R).
        commands: Speeds forward and to the left (m/s) and turn rates (rad/s), shape (3, R).
        allowed: Velocities after the safety filter: rows vx, vy and a `Verdict`, shape (3, R);
            None without a filter.
    """

    wanted: Floats
    commands: Floats
    allowed: Floats | None = None


class Commander:
    """Converts velocities of control laws to commands, offline and over ROS.

    Attributes:
        gains: How robots follow their laws.
        limits: Limits of unicycles whose model has none, if known.
    """

    def __init__(
        self,
        gains: GainOptions,
        options: FilterOptions,
        robots: Sequence[int],
        nb_robots: int,
        report: Callable[[str], None] = print,
    ) -> None:
        """Prepare to command R robots of a fleet of N; `use` sets their models.

        `report` is called with a message when the filter stops robots for long.

        Raises:
            SetcmasError: The filter cannot guarantee safety at this rate.
        """
        self.gains = gains
        self.limits: VelocityLimits | None = None
        self._accel = options.accel or math.inf
        self._own = np.array(robots) - 1
        self._columns = slice(None) if [*robots] == [*range(1, nb_robots + 1)] else self._own
        self._report = report
        self._models: list[RobotModel] = []
        self._last: Floats = np.zeros((3, len(robots)))
        self._filter = None
        if options.is_on:  # loads the solver only if needed
            from setcmas_ctrl.filter.safety_filter import SafetyFilter

            self._filter = SafetyFilter(options, robots, nb_robots)
            if options.gamma > gains.rate:
                raise SetcmasError(
                    f'gamma is {options.gamma:g}; it must be at most the control rate, '
                    f'{gains.rate:g} Hz, or robots could come too close within one period'
                )

    def use(self, models: Sequence[RobotModel]) -> None:
        """Set the models of the R robots, or raise SetcmasError."""
        if list(models) != self._models:
            self._models = list(models)
            self._model = fleet_model(models)
            if self._filter:
                limited = Unicycle(self.limits or IDEAL)
                self._filter.use([limited if _is_unlimited(m) else m for m in models])

    def stop(self) -> Commanded:
        """Return zero commands."""
        self._last = np.zeros((3, len(self._own)))
        return Commanded(np.zeros((2, len(self._own))), self._last)

    def __call__(self, velocities: Floats, poses: Floats) -> Commanded:
        """Return the commands for one period.

        Args:
            velocities: Velocities of the laws: rows vx, vy in m/s, shape (2, R).
            poses: Poses of the fleet: rows x, y in m and theta in rad, shape (3, N).
        """
        gains, Ts = self.gains, 1.0 / self.gains.rate
        wanted = saturate(velocities, gains.vnom)

        def follow(velocities: Floats) -> Floats:
            commands = self._model.command(velocities, poses[:, self._columns], gains.komega)
            return limited_rise(commands, self._last, self._accel * Ts)

        if not self._filter:
            self._last = follow(wanted)
            return Commanded(wanted, self._last)
        if warning := self._filter.start_warning(poses):
            self._report(warning)
        safe = self._filter(wanted, follow, poses, gains.vnom, self._last, Ts)
        if safe.stopped:
            self._report(
                f'the safety filter keeps {robots_in_words(safe.stopped)} stopped: other robots, '
                'the arena or obstacles are in the way'
            )
        self._last = safe.commands
        return Commanded(wanted, safe.commands, np.vstack([safe.velocities, safe.verdicts]))


def _is_unlimited(model: RobotModel) -> bool:
    """Return whether a model is a unicycle whose limits are set elsewhere."""
    return isinstance(model, Unicycle) and model.limits == IDEAL
