"""Conversion of velocities into commands, with limits, and as the safety filter has decided.

The formula itself is in `si_to_uni.py`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.filter.control_points import commands_of_points
from setcmas_ctrl.filter.filter_options import LOOKAHEAD_M, Verdict
from setcmas_ctrl.si_to_uni import Conversion, as_unicycles, conversion_of
from setcmas_simu.arrays import Floats
from setcmas_simu.robots.model import Motion, RobotModel


def limited_rise(commands: Floats, before: Floats, most: float) -> Floats:
    """Limit how much speeds may rise over the previous commands; never limit slowing down.

    Args:
        commands: Speeds forward and to the left (m/s) and turn rates (rad/s), shape (3, N).
        before: The previous commands.
        most: Largest rise in m/s of the speed in the direction of a command.

    Returns:
        The commands, with the same turn rates.
    """
    if most == math.inf:
        return commands
    speeds = np.hypot(commands[0], commands[1])
    directions = commands[:2] / np.maximum(speeds, 1e-12)
    reached = np.maximum(0.0, (directions * before[:2]).sum(axis=0)) + most
    limited: Floats = commands.copy()
    limited[:2] = directions * np.minimum(speeds, reached)
    return limited


class VelocityConversion:
    """Turns velocities into commands, of one robot or of many at once.

    It remembers the last commands, as speeds rise from them by at most `accel`.

    Attributes:
        komega: Gain on heading errors in 1/s.
        Ts: Time between two commands in s.
        scripts: Instead of `si_to_uni`, the conversion of each robot, from the next `use` on.
        last: The last commands: forward and to the left in m/s, turn rate in rad/s, shape (3, R).
    """

    def __init__(
        self,
        nb_robots: int,
        komega: float,
        Ts: float = 0.2,
        accel: float = math.inf,
        scripts: Sequence[Conversion] = (),
    ) -> None:
        """Prepare to convert velocities of R robots; `use` sets their models.

        Args:
            nb_robots: The number R.
            komega: Gain on heading errors in 1/s.
            Ts: Time between two commands in s.
            accel: Largest acceleration in m/s^2; inf is no limit.
            scripts: Instead of `si_to_uni`, the conversion of each robot; none by default.
        """
        self.komega, self.Ts = komega, Ts
        self._accel, self.scripts = accel, scripts
        self.last: Floats = np.zeros((3, nb_robots))
        self._groups: list[tuple[Conversion, bool, Any]] = []

    def use(self, models: Sequence[RobotModel]) -> None:
        """Set the models of the R robots; robots that are driven alike are converted together."""
        self._turns = np.array([model.motion is Motion.UNICYCLE for model in models])
        scripts = self.scripts or [as_unicycles] * len(models)
        found = map(conversion_of, models, scripts)
        ways = list(zip(found, self._turns.tolist(), strict=True))
        self._groups = [
            (
                *way,
                np.flatnonzero([one == way for one in ways]) if {*ways} != {way} else slice(None),
            )
            for way in dict.fromkeys(ways)
        ]
        limits = [model.limits for model in models]
        self._half_separation = np.array([0.5 * limit.wheel_separation for limit in limits])
        most = [
            (min(model.V_max, limit.V_max), limit.omega_max, limit.wheel_speed_max)
            for model, limit in zip(models, limits, strict=True)
        ]
        self._most = np.where(self._turns, np.transpose(most), math.inf)

    def __call__(
        self,
        velocities: Floats,
        poses: Floats,
        verdicts: NDArray[np.int64] | None = None,
        kept: Floats | None = None,
    ) -> Floats:
        """Return the commands for velocities (2, R) in m/s at poses (3, R), and remember them.

        Args:
            velocities: Rows vx, vy in m/s.
            poses: Rows x, y in m and theta in rad.
            verdicts: What the safety filter did with each velocity, shape (R,); None without it.
            kept: What `follow` returned for the robots with kept velocities, if called before.
        """
        if verdicts is None:
            self.last = self._followed(velocities, poses)
            return self.last
        commands = self.follow(velocities, poses) if kept is None else kept
        is_changed = verdicts != Verdict.KEPT
        if is_changed.any():
            commands = np.where(is_changed, self._changed(velocities, poses), commands)
        self.last = commands
        return commands

    def follow(self, velocities: Floats, poses: Floats) -> Floats:
        """Return the commands that robots get if the safety filter keeps their velocities."""
        return self._within_limits(self._followed(velocities, poses))

    def _followed(self, velocities: Floats, poses: Floats) -> Floats:
        if len(self._groups) == 1:  # the usual case
            convert, _, _ = self._groups[0]
            commands = convert(velocities, poses, self.komega)
        else:
            commands = np.empty(poses.shape)
            for convert, _, robots in self._groups:
                commands[:, robots] = convert(velocities[:, robots], poses[:, robots], self.komega)
        return limited_rise(commands, self.last, self._accel * self.Ts)

    def _within_limits(self, commands: Floats) -> Floats:
        """Scale commands of unicycles down to their limits, on the same curves."""
        V, omega = np.abs(commands[0]), np.abs(commands[2])
        speeds = np.stack([V, omega, V + self._half_separation * omega])
        scaled: Floats = commands / np.maximum(1.0, (speeds / self._most).max(axis=0))
        return scaled

    def _changed(self, velocities: Floats, poses: Floats) -> Floats:
        """Return the commands that give control points their velocities; zero without a pose."""
        commands = commands_of_points(velocities, poses[2], LOOKAHEAD_M, self.Ts)
        for convert, turns, robots in self._groups:
            if not turns:  # the control point is the robot's centre
                commands[:, robots] = convert(velocities[:, robots], poses[:, robots], self.komega)
        return np.where(np.isfinite(commands).all(axis=0), commands, 0.0)
