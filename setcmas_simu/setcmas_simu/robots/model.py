"""Robot model: how robots of one kind turn velocities into motion; limits and shape."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError

Velocities = tuple[Floats, Floats]


@dataclass(frozen=True)
class VelocityLimits:
    """Velocity limits of a differential-drive robot.

    Attributes:
        V_max: Largest forward or backward speed, in m/s.
        omega_max: Largest turn rate, in rad/s.
        wheel_speed_max: Largest rim speed of a wheel, in m/s.
        wheel_separation: Distance between the wheels, in m.
    """

    V_max: float
    omega_max: float
    wheel_speed_max: float
    wheel_separation: float

    def saturate(self, V: ArrayLike, omega: ArrayLike) -> Velocities:
        """Clamp forward speed and turn rate separately, then each wheel, as OpenCR firmware does.

        Takes and returns forward speeds in m/s and turn rates in rad/s, shapes (N,).
        """
        forward, turn = np.asarray(V, dtype=float), np.asarray(omega, dtype=float)
        if self == IDEAL:
            return forward, turn
        forward = np.clip(forward, -self.V_max, self.V_max)
        turn = np.clip(turn, -self.omega_max, self.omega_max)
        half = 0.5 * self.wheel_separation * turn
        left = np.clip(forward - half, -self.wheel_speed_max, self.wheel_speed_max)
        right = np.clip(forward + half, -self.wheel_speed_max, self.wheel_speed_max)
        return 0.5 * (left + right), (right - left) / self.wheel_separation

    def scaled_down(self, V: float, omega: float) -> tuple[float, float]:
        """Scale V (m/s) and omega (rad/s) down by one factor, which keeps the path's curvature.

        Forward speed, turn rate and both wheels are then within their limits.
        """
        wheel = self.faster_wheel(V, omega)
        excess = max(
            1.0, abs(V) / self.V_max, abs(omega) / self.omega_max, wheel / self.wheel_speed_max
        )
        return V / excess, omega / excess

    def faster_wheel(self, V: float, omega: float) -> float:
        """Return the rim speed of the faster wheel in m/s, forward or backward."""
        return abs(V) + 0.5 * self.wheel_separation * abs(omega)


IDEAL = VelocityLimits(math.inf, math.inf, math.inf, 0.160)
"""No limits, as in ROS 1."""

ROBOT_LIMITS = {
    'burger': VelocityLimits(0.2108, 2.635, 0.2667, 0.160),
    'waffle': VelocityLimits(0.2661, 1.854, 0.2667, 0.287),
}
"""Limits of real robots by name, from the firmware of the TurtleBot3 models."""

LIMITS = {'ideal': IDEAL, **ROBOT_LIMITS}
"""Limits of simulated robots by name."""


def limits_named(name: str) -> VelocityLimits:
    """Return the limits with this name, or raise SetcmasError."""
    if name not in LIMITS:
        raise SetcmasError(f"unknown limits '{name}'; must be one of {', '.join(LIMITS)}")
    return LIMITS[name]


Points = tuple[tuple[float, float], ...]
"""Corners x, y in m."""

_DISC_CORNERS = 32


@dataclass(frozen=True)
class Shape:
    """Size of a robot in m, from above; x is forward.

    Attributes:
        outline: Corners for plots, films and the page; may be concave, and shows the heading.
        body: Corners for RViz and collisions; convex, counter-clockwise.
        height: Height for RViz.
    """

    outline: Points
    body: Points
    height: float


def disc(radius: float) -> Points:
    """Return the corners of a disc of a radius in m."""
    angles = [math.tau * i / _DISC_CORNERS for i in range(_DISC_CORNERS)]
    return tuple((radius * math.cos(angle), radius * math.sin(angle)) for angle in angles)


def mirrored(points: Points) -> Points:
    """Return a counter-clockwise outline from its half with y >= 0, front first."""
    return (*points, *((x, -y) for x, y in reversed(points) if y > 0))


SLOW = 0.01
"""Speed in m/s below which a robot counts as stopped; a TurtleBot3 cannot go slower."""

POSE, TWIST = slice(0, 3), slice(3, 6)
"""Rows of a state: x, y (m), theta (rad); and the velocities of the last step along the robot's
axes: forward, to the left (m/s), turn rate (rad/s)."""


class Motion(enum.Enum):
    """What can follow a velocity in any direction: a point of the robot, the robot, or nothing."""

    UNICYCLE = 'a point ahead of the axle goes in every direction'
    FREE = 'the robot itself does'
    OTHER = 'neither does'


@runtime_checkable
class RobotModel(Protocol):
    """How N robots of one kind move, all at once; models keep nothing between calls.

    States have the rows of POSE and TWIST, and any further rows that the model needs. Commands
    have the rows of TWIST, as on cmd_vel.

    Robots are driven as unicycles, by `setcmas_ctrl.si_to_uni`, unless their model has a method

        def command(self, velocities, poses, komega): ...

    which returns the commands (3, N) that give robots their velocities (2, N) in m/s, in the world
    frame, as far as possible, at poses (3, N); komega is the gain on heading errors in 1/s.

    Attributes:
        shape: Shape of a robot.
        V_max: Largest speed in any direction in m/s.
        motion: What can follow a velocity in any direction.
        limits: Speed limits, for robots with wheels.
        failed: Whether a step has failed; only users' scripts can fail.
    """

    shape: Shape
    V_max: float = math.inf
    motion: Motion = Motion.UNICYCLE
    limits: VelocityLimits = IDEAL
    failed: bool = False

    def start(self, poses: Floats) -> Floats:
        """Return the states of robots at rest at poses (x, y in m, theta in rad; (3, N))."""
        return np.concatenate([poses, np.zeros((3, poses.shape[1]))])

    def step(self, states: Floats, commands: Floats, Ts: float) -> Floats:
        """Return the states one period of Ts s later, in a new array.

        States have the shape (S, N), with S rows as from `start`; commands (3, N) are finite.
        """
        ...
