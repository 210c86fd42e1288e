"""Commander: from the velocities of control laws to the commands of their robots."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.laws.control_options import GainOptions
from setcmas_ctrl.saturation import saturate
from setcmas_ctrl.si_to_uni import Conversion, VelocityConversion
from setcmas_simu.arrays import Floats, single_precision
from setcmas_simu.robots.model import RobotModel


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
    """Saturation, safety filter and conversion in a row, for the R robots of a process."""

    def __init__(
        self,
        gains: GainOptions,
        options: FilterOptions,
        robots: Sequence[int],
        nb_robots: int,
        report: Callable[[str], None] = print,
        scripts: Sequence[Conversion] = (),
    ) -> None:
        """Prepare to command R robots of a fleet of N; `use` sets their models.

        `report` is called with a message when the filter stops robots for long; `scripts` are the
        conversions of the R robots, instead of the built-in one.

        Raises:
            SetcmasError: The filter cannot guarantee safety at this rate.
        """
        self._vnom = gains.vnom
        self._columns = (
            slice(None) if [*robots] == [*range(1, nb_robots + 1)] else np.array(robots) - 1
        )
        self._convert = VelocityConversion(
            len(robots),
            gains.komega,
            1.0 / gains.rate,
            options.accel or math.inf,
            options.lookahead,
            scripts,
        )
        self._filter = None
        if options.is_on:  # loads the solver only if needed
            from setcmas_ctrl.filter.safety_filter import SafetyFilter

            self._filter = SafetyFilter(options, robots, nb_robots, self._convert, report)

    def use(self, models: Sequence[RobotModel]) -> None:
        """Set the models of the R robots, or raise SetcmasError."""
        (self._filter or self._convert).use(models)

    def __call__(self, velocities: Floats, poses: Floats) -> Commanded:
        """Return the commands for one period.

        Args:
            velocities: Velocities of the laws: rows vx, vy in m/s, shape (2, R).
            poses: Poses of the fleet: rows x, y in m and theta in rad, shape (3, N).
        """
        convert = self._convert
        wanted = single_precision(saturate(velocities, self._vnom))
        if not self._filter:
            return Commanded(wanted, convert(wanted, poses[:, self._columns]))
        allowed = self._filter(wanted, poses, self._vnom)
        return Commanded(wanted, convert.last, np.vstack(allowed))
