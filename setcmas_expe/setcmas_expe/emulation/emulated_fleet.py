"""Emulated fleet of TurtleBot3s, with the real ones' response to commands."""

from __future__ import annotations

import math

import numpy as np

from setcmas_expe.emulation.faults import FaultKind
from setcmas_simu.arrays import Floats
from setcmas_simu.robots import unicycle
from setcmas_simu.robots.model import TWIST, RobotModel, VelocityLimits
from setcmas_simu.robots.unicycle import Unicycle

_RESOLUTION = 100  # 1/(m/s), 1/(rad/s): the robot's computer sends whole hundredths to OpenCR
_INT32_MAX = 2**31 - 1
_PUSH_SPEED = 0.4  # m/s
_FULL = 100.0  # percent
_ENDURANCE_S = 2.5 * 3600  # of a Burger's battery, as ROBOTIS states it
_RADIUS_M = 0.07  # of a robot, for the lidars of the others

LIDAR_RATE_HZ = 5.0
"""Turns per second of the lidar LDS-01."""

LIDAR_POINTS = 360
"""Points that the lidar measures per turn, starting straight ahead and going left."""


def truncated(velocity: float) -> float:
    """Return a velocity (m/s or rad/s) as it reaches the motors: int32(100 v) / 100.

    The conversion of turtlebot3_node on a Raspberry Pi: NaN becomes 0, and large values the
    largest integer.
    """
    if math.isnan(velocity):
        return 0.0
    return int(max(-_INT32_MAX, min(_INT32_MAX, _RESOLUTION * velocity))) / _RESOLUTION


class EmulatedFleet:
    """Robots that follow their last command until another one arrives.

    Attributes:
        poses: True poses: rows x, y in m and theta in rad, shape (3, N).
        V: Forward speeds of their wheels over the last step in m/s, shape (N,).
        omega: Turn rates over the last step in rad/s, shape (N,).
        odometry: Poses by their wheels, from (0, 0, 0) at the start, shape (3, N).
        battery: Charge in percent, shape (N,).
    """

    def __init__(
        self,
        start_poses: Floats,
        limits: VelocityLimits,
        rng: np.random.Generator,
        model: RobotModel | None = None,
    ) -> None:
        """Place the robots at poses with rows x, y in m and theta in rad, shape (3, N).

        They follow commands as the model does, at once by default, within the limits of their
        firmware. `rng` draws the charge of their batteries.
        """
        nb_robots = start_poses.shape[1]
        self.poses = np.array(start_poses, dtype=float)
        self.odometry = np.zeros((3, nb_robots))
        self.V = np.zeros(nb_robots)
        self.omega = np.zeros(nb_robots)
        self.battery = _FULL - rng.uniform(0.0, 20.0, (nb_robots,))
        self._limits = limits
        self._model = model or Unicycle()
        self._states = self._model.start(self.poses)
        self._commands = np.zeros((2, nb_robots))
        self._torque = np.ones(nb_robots)
        self._left = {
            kind: np.zeros(nb_robots)
            for kind in (FaultKind.BLOCKED, FaultKind.STALLED, FaultKind.DEAF, FaultKind.PUSH)
        }
        self._pushes = np.zeros((2, nb_robots))

    def command(self, index: int, V: float, omega: float) -> None:
        """Have a robot follow a command (m/s, rad/s) from now on, unless it takes none."""
        if self._left[FaultKind.DEAF][index] <= 0.0:
            self._commands[:, index] = truncated(V), truncated(omega)

    def set_torque(self, index: int, on: bool) -> None:
        """Switch the motors of a robot on or off; they are on at the start."""
        self._torque[index] = on

    def push_outwards(self, index: int, middle: tuple[float, float], duration: float) -> None:
        """Push a robot away from a point (m) for a time (s); its wheels slip."""
        away = self.poses[:2, index] - middle
        distance = float(np.hypot(*away))
        direction = away / distance if distance > 0 else np.array([1.0, 0.0])
        self._pushes[:, index] = _PUSH_SPEED * direction
        self.fail(FaultKind.PUSH, index, duration)

    def fail(self, kind: FaultKind, index: int, duration: float) -> None:
        """Begin a fault (BLOCKED, STALLED, DEAF or PUSH) of a robot that lasts for a time (s)."""
        self._left[kind][index] = duration

    def step(self, Ts: float) -> None:
        """Move all robots by one period of Ts s."""
        turns = self._torque * (self._left[FaultKind.STALLED] <= 0.0)
        V, omega = self._limits.saturate(*(self._commands * turns))
        self._states = self._model.step(self._states, np.stack([V, 0.0 * V, omega]), Ts)
        self.V, self.omega = self._states[TWIST][[0, 2]] * turns
        free = self._left[FaultKind.BLOCKED] <= 0.0
        self.poses = unicycle.step(self.poses, self.V * free, self.omega * free, Ts)
        self.poses[:2] += np.minimum(Ts, self._left[FaultKind.PUSH]) * self._pushes
        for left in self._left.values():
            np.maximum(0.0, left - Ts, out=left)
        self.odometry = unicycle.step(self.odometry, self.V, self.omega, Ts)
        self.battery = np.maximum(0.0, self.battery - _FULL * Ts / _ENDURANCE_S)

    def scan(self, index: int, people: Floats) -> Floats:
        """Return the distances in m that a lidar measures in a turn, shape (LIDAR_POINTS,).

        The robot's lidar sees the other robots, and `people`: discs with rows x, y,
        radius in m, shape (3, M). The distance is inf where it sees nothing.
        """
        others = np.delete(self.poses[:2], index, axis=1)
        robots = np.vstack([others, np.full(others.shape[1], _RADIUS_M)])
        discs = np.hstack([people, robots])
        x, y = discs[:2] - self.poses[:2, [index]]
        angles = np.linspace(0.0, 2.0 * math.pi, LIDAR_POINTS, endpoint=False)
        turned = np.arctan2(y, x) - self.poses[2, index] - angles[:, np.newaxis]
        ahead, beside = np.hypot(x, y) * (np.cos(turned), np.sin(turned))
        half_chord = np.sqrt(np.maximum(0.0, discs[2] ** 2 - beside**2))
        hits = (np.abs(beside) < discs[2]) & (ahead > 0.0)
        seen: Floats = np.where(hits, ahead - half_chord, math.inf).min(axis=1, initial=math.inf)
        return seen
