"""Lab: its robots, its motion capture system, and its safety limits."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_expe.mocap.sources import MocapSource
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.robots.arena import Arena, Obstacles
from setcmas_simu.robots.model import VelocityLimits

LOW_PERCENT = 15.0
"""Charge below which users are warned."""


class BatteryScale:
    """Reads sensor_msgs/BatteryState.percentage, 0 to 1 by its definition.

    turtlebot3_node sends 0 to 100: after a value above 1, all values are percentages.
    """

    def __init__(self) -> None:
        self._in_percent = False

    def percent(self, percentage: float) -> float | None:
        """Return the charge in percent; None if unknown."""
        if not math.isfinite(percentage):
            return None
        self._in_percent = self._in_percent or percentage > 1.0
        return float(percentage if self._in_percent else 100.0 * percentage)


_LARGEST_M = 100.0  # of a lab, from its origin: more are mm, or a mistake
_TYRE_M = 0.02  # a robot is wider than the distance between its wheels by this
_FILTER_MARGIN_M = 0.05  # between robots, beyond the distance at which they stop


def robot_width(limits: VelocityLimits) -> float:
    """Return the width in m of a robot with these limits."""
    return limits.wheel_separation + _TYRE_M


@dataclass(frozen=True)
class LabRobot:
    """A real robot.

    Attributes:
        number: Its number in control laws, from 1.
        mocap_name: Name of its rigid body in the motion capture system.
        namespace: Namespace of the robot's own nodes, without a slash.
        start: Measured start pose, x, y in m and heading in rad; None if it is not given.
    """

    number: int
    mocap_name: str
    namespace: str
    start: tuple[float, float, float] | None = None

    @classmethod
    def numbered(cls, number: int) -> LabRobot:
        """Return a robot that is called tb3_<number> everywhere."""
        return cls(number, robot_name(number), robot_name(number))

    def topic(self, name: str) -> str:
        """Return the full name of a topic of the robot's own nodes, such as /tb3_2/cmd_vel."""
        return f'/{self.namespace}/{name}'


@dataclass(frozen=True)
class Mocap:
    """A motion capture system.

    Attributes:
        preset: Name of its source, or 'custom'.
        source: Topics and messages of its driver.
        y_up: Whether its y axis points upwards.
    """

    preset: str
    source: MocapSource
    y_up: bool

    def topic_of(self, robot: LabRobot) -> str:
        """Return the topic on which the driver sends a robot's pose."""
        return self.source.topic_of(robot.mocap_name)


@dataclass(frozen=True)
class Timeouts:
    """Largest ages in s of poses, commands and the pause state."""

    pose_s: float
    command_s: float
    pause_s: float


@dataclass(frozen=True)
class Lab:
    """A lab; `lab_file.load_lab` reads it.

    Attributes:
        robots: The robots, numbered 1 to N in this order.
        arena: Where robots may be.
        min_separation: Smallest distance between two robots' centres, in m.
        obstacles: Obstacles for the robots.
        filter: The safety filter between control laws and robots: 'barrier' or 'none'.
        limits: Speed limits of the robots.
        accel: Largest increase of their forward speed, in m/s^2; inf is no limit.
        timeouts: When robots stop for lack of messages.
        checks_motion: Whether robots must be seen to move as commanded.
        lidar_stop: Whether every guard must watch the lidar of its robot.
        guarded: Whether every robot must have a cmd_vel_guard.
        joystick_button: Index of the button that starts, from 0.
        joystick_topic: Topic of the joystick.
        static_peers: Addresses of the other machines, for networks without multicast.
    """

    robots: tuple[LabRobot, ...]
    mocap: Mocap
    arena: Arena
    min_separation: float
    obstacles: Obstacles
    filter: str
    limits: VelocityLimits
    accel: float
    timeouts: Timeouts
    checks_motion: bool
    lidar_stop: bool
    guarded: bool
    joystick_button: int
    joystick_topic: str
    static_peers: tuple[str, ...]

    @property
    def nb_robots(self) -> int:
        """Number of robots."""
        return len(self.robots)

    def safety(self, others: FilterOptions) -> FilterOptions:
        """Return options with those of the safety filter set as in this lab.

        Raises:
            ClashError: They contradict each other.
        """
        return replace(
            others,
            filter=self.filter,
            min_separation=self.min_separation + _FILTER_MARGIN_M,
            arena=self.arena,
            obstacles=str(self.obstacles) or None,
            accel=self.accel if self.accel < math.inf else None,
        )

    def check_geometry(self) -> None:
        """Check that robots fit into the lab.

        Raises:
            SetcmasError: A length cannot be one in m, or robots could touch each other.
        """
        lengths: list[tuple[str, tuple[float, ...]]] = [('arena', self.arena)]
        lengths += [('obstacle disc', disc) for disc in self.obstacles.discs]
        lengths += [('obstacle polygon', sum(p.corners, ())) for p in self.obstacles.polygons]
        for name, values in lengths:
            if max(map(abs, values)) > _LARGEST_M:
                written = ', '.join(f'{value:g}' for value in values)
                raise SetcmasError(
                    f'{name} is {written}; it must be in m, within {_LARGEST_M:g} m of the origin'
                )
        self.check_separation()
        width = robot_width(self.limits)
        xmin, xmax, ymin, ymax = self.arena
        if min(xmax - xmin, ymax - ymin) < width:
            raise SetcmasError(
                f'the arena is {xmax - xmin:g} m by {ymax - ymin:g} m; it must be wider than a '
                f'robot, {width:.2f} m'
            )
        for robot in self.robots if self.mocap.source.from_start else ():
            if robot.start and self.arena.distance(*robot.start[:2]):
                raise SetcmasError(
                    f'the start pose of robot {robot.number}, ({robot.start[0]:g}, '
                    f'{robot.start[1]:g}) m, is outside the arena'
                )

    def check_separation(self) -> None:
        """Check that robots cannot touch at their minimum separation, or raise SetcmasError."""
        width = robot_width(self.limits)
        if self.min_separation < width:
            raise SetcmasError(
                f'min_separation is {self.min_separation:g} m; it must be at least the width of a '
                f'robot, {width:.2f} m'
            )

    def check_rate(self, rate: float) -> None:
        """Check that robots do not stop between two commands at a control rate in Hz.

        Raises:
            SetcmasError: It is too low.
        """
        longest = self.timeouts.command_s
        if rate * longest <= 1:
            raise SetcmasError(
                f'--rate is {rate:g}; it must be above {1 / longest:g} Hz in this lab, where a '
                f'robot stops {longest:g} s after its last command (timeouts: command)'
            )
