"""si_to_uni: turns the velocity of a law, vx and vy, into the command of a robot, V and omega.

The function `si_to_uni` converts; change it, and every unicycle is driven your way, over ROS and
offline. `VelocityConversion` is what surrounds it: other kinds of robots, limited acceleration,
velocities that the safety filter has changed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from setcmas_ctrl.filter.control_points import commands_of_points
from setcmas_ctrl.filter.filter_options import LOOKAHEAD_M, Verdict
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.planar_pose import wrap_angle
from setcmas_simu.robots.model import SLOW, Motion, RobotModel

_SLOW_TURN = 0.01  # rad/s: a TurtleBot3 cannot turn slower


def si_to_uni(velocities: ArrayLike, theta: ArrayLike, komega: float) -> tuple[Floats, Floats]:
    """Turn robots towards their desired velocities and drive at their speed.

    V = |v| and omega = komega wrap(atan2(vy, vx) - theta): the proportional heading control of
    the ROS 1 stack (Bertrand, ECC 2024), with the error wrapped so that robots turn the short
    way. A robot slower than 0.01 m/s does not turn, and turn rates below 0.01 rad/s become 0.
    A robot whose velocity or heading is not finite stops.

    Args:
        velocities: Rows vx, vy in m/s in the world frame, shape (2, N).
        theta: Headings in rad, shape (N,).
        komega: Gain on the heading error in 1/s.

    Returns:
        Forward speeds in m/s and turn rates in rad/s, shapes (N,).
    """
    v = np.asarray(velocities, dtype=float)
    V = np.asarray(np.hypot(v[0], v[1]))
    omega = np.asarray(komega * wrap_angle(np.arctan2(v[1], v[0]) - theta))
    turn = np.abs(omega)
    goes = np.isfinite(V + turn)
    turns = goes & (V >= SLOW) & (turn >= _SLOW_TURN)
    V[~goes] = omega[~turns] = 0.0
    return V, omega


Conversion = Callable[[Floats, Floats, float], Floats]
"""From velocities (2, N) and poses (3, N) of robots, and komega in 1/s, to commands (3, N)."""


def as_unicycles(velocities: Floats, poses: Floats, komega: float) -> Floats:
    """Return the commands of unicycles by `si_to_uni`: V (m/s), zeros, omega (rad/s); (3, N)."""
    commands = np.zeros(poses.shape)
    commands[0], commands[2] = si_to_uni(velocities, poses[2], komega)
    return commands


def conversion_of(model: RobotModel, otherwise: Conversion = as_unicycles) -> Conversion:
    """Return how robots of a model are driven: by its own method `command`, if it has one."""
    own: Conversion | None = getattr(model, 'command', None)
    return own or otherwise


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
        lookahead: float = LOOKAHEAD_M,
        scripts: Sequence[Conversion] = (),
    ) -> None:
        """Prepare to convert velocities of R robots; `use` sets their models.

        Args:
            nb_robots: The number R.
            komega: Gain on heading errors in 1/s.
            Ts: Time between two commands in s.
            accel: Largest acceleration in m/s^2; inf is no limit.
            lookahead: Distance in m from a unicycle's axle to the point whose velocity the safety
                filter changes.
            scripts: Instead of `si_to_uni`, the conversion of each robot; none by default.
        """
        self.komega, self.Ts = komega, Ts
        self._accel, self._lookahead, self.scripts = accel, lookahead, scripts
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
        commands = commands_of_points(velocities, poses[2], self._lookahead, self.Ts)
        for convert, turns, robots in self._groups:
            if not turns:  # the control point is the robot's centre
                commands[:, robots] = convert(velocities[:, robots], poses[:, robots], self.komega)
        return np.where(np.isfinite(commands).all(axis=0), commands, 0.0)
