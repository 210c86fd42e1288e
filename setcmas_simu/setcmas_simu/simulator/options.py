"""Options of a simulation, the same for `setcmas simu` and for the node's own command line."""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import parse_robots
from setcmas_simu.fleet.pose_options import chosen_start_poses
from setcmas_simu.fleet.topics import CMD_VEL_TYPES
from setcmas_simu.options import count, positive, rate
from setcmas_simu.robots.unicycle import RATE_HZ
from setcmas_simu.robots.velocity_limits import MODELS


@dataclass(frozen=True)
class SimulatedRobots:
    """The robots that one process simulates.

    Attributes:
        robots: Their numbers, sorted.
        start_poses: Rows x, y in m and theta in rad, a column for each of `robots`.
    """

    robots: list[int]
    start_poses: NDArray[np.float64]


def add_start_pose_arguments(group: argparse._ArgumentGroup) -> None:
    """Add --poses and --pose."""
    group.add_argument(
        '--poses',
        type=Path,
        metavar='FILE',
        help='start poses in a YAML file: a list [x, y, theta]',
    )
    group.add_argument(
        '--pose',
        action='append',
        default=[],
        metavar='I:X,Y,THETA',
        help='start pose of robot I in m and rad, such as 3:1.0,2.0,1.57; may be repeated',
    )


def add_limits_argument(group: argparse._ArgumentGroup) -> None:
    """Add --limits."""
    group.add_argument(
        '--limits',
        choices=list(MODELS),
        default='ideal',
        help='saturation of the robots: none, or as that TurtleBot3 (default: %(default)s)',
    )


def add_cmd_timeout_argument(group: argparse._ArgumentGroup) -> None:
    """Add --cmd-timeout."""
    group.add_argument(
        '--cmd-timeout',
        type=positive,
        default=math.inf,
        metavar='S',
        help='stop a robot whose last command is older than this, in s (default: never)',
    )


def add_robot_rate_argument(group: argparse._ArgumentGroup) -> None:
    """Add --robot-rate."""
    group.add_argument(
        '--robot-rate',
        type=rate,
        default=RATE_HZ,
        metavar='HZ',
        help='rate of integration and odometry (default: %(default)g)',
    )


def add_simulation_arguments(parser: argparse.ArgumentParser) -> None:
    """Add every option of a simulation."""
    group = parser.add_argument_group('simulated robots')
    group.add_argument(
        '--nb-robots', type=count, metavar='N', help='size of the fleet (default: 1)'
    )
    group.add_argument(
        '--robots', metavar='LIST', help="simulate only these robots of it, such as '1-4'"
    )
    add_start_pose_arguments(group)
    add_limits_argument(group)
    add_cmd_timeout_argument(group)
    add_robot_rate_argument(group)
    group.add_argument(
        '--cmd-vel-type',
        choices=CMD_VEL_TYPES,
        default=CMD_VEL_TYPES[0],
        help='message type that the robots listen to on cmd_vel (default: %(default)s)',
    )


def simulated_robots(args: argparse.Namespace) -> SimulatedRobots:
    """Return the robots that parsed options ask for.

    Raises:
        SetcmasError: The options contradict each other, or poses are malformed.
    """
    named = parse_robots(args.robots) if args.robots else None
    nb_robots = args.nb_robots or (named[-1] if named else 1)
    robots = named or list(range(1, nb_robots + 1))
    if robots[-1] > nb_robots:
        raise SetcmasError(
            f"--robots '{args.robots}' names robot {robots[-1]}; "
            f'the fleet has robots 1 to {nb_robots} (--nb-robots)'
        )
    poses = chosen_start_poses(nb_robots, args.poses, args.pose)
    return SimulatedRobots(robots, poses[:, [robot - 1 for robot in robots]])
