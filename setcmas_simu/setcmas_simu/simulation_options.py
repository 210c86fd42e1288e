"""Options of a simulation, the same for `setcmas simu` and for the node's own command line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

from setcmas_simu import option_kinds as kinds
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.fleet import check_in_fleet, format_robots, start_poses
from setcmas_simu.fleet.start_poses import (
    AUTO,
    FORM,
    GivenPoses,
    RandomPoses,
    given_poses,
    poses_of_entry,
)
from setcmas_simu.fleet.topics import CMD_VEL_TYPES
from setcmas_simu.option_groups import Form, Options, option
from setcmas_simu.robots.model import LIMITS
from setcmas_simu.robots.models_by_name import (
    NO_LIMITS,
    UNICYCLE,
    check_models,
    model_names,
)
from setcmas_simu.robots.unicycle import RATE_HZ
from setcmas_simu.yaml_entries import Entry


@dataclass(frozen=True)
class SimulatedRobots:
    """Robots of one process, by ascending number; start poses (m, rad) have a column for each."""

    robots: list[int]
    start_poses: Floats
    models: list[str]


@dataclass(frozen=True)
class _StartPoses(kinds.PathTo):
    """A file of start poses; in YAML and Python also the poses themselves."""

    must_be = 'a file, a list of poses [x, y, theta], or a mapping from robots to poses'

    def read(self, entry: Entry, place: Callable[[str], str]) -> Any:
        """Return the path of a file, the poses of a list, or poses by robot."""
        if isinstance(entry.value, str):
            return super().read(entry, place)
        poses = poses_of_entry(entry)
        return tuple(poses.values()) if isinstance(entry.value, list) else poses

    def accepts(self, value: Any) -> bool:
        """Return whether a value is a path, a tuple of poses, or poses by robot."""
        return isinstance(value, (dict, tuple)) or super().accepts(value)


@dataclass(frozen=True, kw_only=True)
class StartPoseOptions(Options):
    """Start poses of simulated or emulated robots."""

    TITLE: ClassVar[str] = 'emulated lab'

    poses: GivenPoses | None = option(
        _StartPoses(), 'YAML file of start poses: [x, y, theta] for each robot', default=None
    )
    pose: tuple[str, ...] = option(
        kinds.Kind(metavar='I:X,Y[,THETA]'),
        'start pose of robot I in m and rad, such as 3:1.0,2.0,1.57 (default THETA: 0); may be '
        'repeated',
        form=Form.REPEATED,
        default=(),
    )
    random_poses: str | None = option(
        kinds.ParsedText(RandomPoses.of, FORM, metavar='box=WxH,distance=D'),
        'random poses for robots without a start pose: box size and least distance in m '
        '(default: 10x10 and 1, adapted if too tight)',
        default=None,
        alone=AUTO,
    )
    seed: int = option(kinds.SEEDS, 'seed of random start poses', default=0)

    def start_poses(
        self,
        nb_robots: int,
        defaults: Floats | None = None,
        within: Callable[[RandomPoses], RandomPoses] | None = None,
    ) -> Floats:
        """Return where a fleet starts: x, y in m and theta in rad, shape (3, nb_robots).

        Single poses go before the file, the file before `defaults` (`fleet.start_poses` without)
        or random poses, which `within` fits into a room.

        Raises:
            SetcmasError: A pose is malformed or outside the fleet, or random ones do not fit.
        """
        given = given_poses(nb_robots, self.poses, self.pose)
        if self.random_poses:
            places = RandomPoses.of(self.random_poses)
            return (within(places) if within else places).draw(nb_robots, self.seed, given)
        poses = start_poses(nb_robots) if defaults is None else defaults.copy()
        for robot, pose in given.items():
            poses[:, robot - 1] = pose
        return poses


@dataclass(frozen=True, kw_only=True)
class ClockOptions(Options):
    """How simulated time goes by."""

    TITLE: ClassVar[str] = 'robots'

    rtf: float = option(
        kinds.Number(above=0, most=100, metavar='FACTOR'),
        'real-time factor: simulated seconds per second',
        default=1.0,
    )


CMD_TIMEOUT_S = 1.0
"""Default time without a command after which a robot stops, in s."""


@dataclass(frozen=True)
class _CommandTimeout(kinds.Number):
    """Times without a command: 0, which is never, or longer than between two commands."""

    must_be = 'at least 0.3 s, or 0 for never'

    def accepts(self, value: Any) -> bool:
        """Return whether a value is 0 or long enough."""
        return super().accepts(value) and (value == 0 or value >= 0.3)


@dataclass(frozen=True, kw_only=True)
class RobotOptions(StartPoseOptions):
    """Which robots there are, where they start, and how they move."""

    TITLE: ClassVar[str] = 'robots'

    nb_robots: int | None = option(
        kinds.NB_ROBOTS, 'size of the fleet', default=None, default_text='1'
    )
    model: str | None = option(
        kinds.NameOrFile(metavar='MODEL'),
        'robot model: a name (see setcmas list), a script such as my_robot.py, a file '
        "written by setcmas identify, or per robot: '1:burger,2-4:my_robot.py'",
        default=None,
        default_text=UNICYCLE,
    )
    limits: str = option(
        kinds.OneOf(tuple(LIMITS)),
        'velocity limits of unicycles: none (ideal), or those of a TurtleBot3',
        default=NO_LIMITS,
    )
    cmd_timeout: float = option(
        _CommandTimeout(least=0, unit='s'),
        'stop a robot after this long without a command; 0 means never, as in ROS 1',
        default=CMD_TIMEOUT_S,
    )
    robot_rate: float = option(
        kinds.RATE, 'rate at which robots move and publish odometry', default=RATE_HZ
    )

    def nb_steps(self, duration: float) -> int:
        """Return how many steps the robots do in a run of `duration` s."""
        return max(1, round(duration * self.robot_rate))

    @property
    def fleet_size(self) -> int:
        """Number of robots in the fleet."""
        return self.nb_robots or 1


@dataclass(frozen=True, kw_only=True)
class SimulationOptions(RobotOptions, ClockOptions):
    """What a simulator simulates: all robots of a fleet, or some."""

    TITLE: ClassVar[str] = 'robots'

    robots: tuple[int, ...] | None = option(
        kinds.Robots(), "simulate only these robots of the fleet, such as '1-4'", default=None
    )
    cmd_vel_type: str = option(
        kinds.OneOf(tuple(CMD_VEL_TYPES)), 'message type of cmd_vel', default=CMD_VEL_TYPES[0]
    )

    @property
    def fleet_size(self) -> int:
        """Number of robots in the fleet."""
        return self.nb_robots or (self.robots[-1] if self.robots else 1)

    def simulated(self) -> SimulatedRobots:
        """Return the robots that these options ask for, or raise SetcmasError."""
        nb_robots = self.fleet_size
        robots = list(self.robots or range(1, nb_robots + 1))
        check_in_fleet(robots, nb_robots, f"--robots '{format_robots(robots)}'")
        poses = self.start_poses(nb_robots)
        models = model_names(self.model, nb_robots)
        check_models(models, self.limits)
        columns = [robot - 1 for robot in robots]
        return SimulatedRobots(robots, poses[:, columns], [models[i] for i in columns])
