"""Options of a controller, the same for `setcmas ctrl` and for the node's own command line."""

from __future__ import annotations

import argparse

from setcmas_ctrl.control.saturation import VNOM
from setcmas_ctrl.scripts.random_seed import SEED, seed
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import parse_robots
from setcmas_simu.fleet.topics import AUTO, CMD_VEL_TYPES
from setcmas_simu.options import count, positive, rate
from setcmas_simu.robots.si_to_uni import KOMEGA

RATE_HZ = 5.0
"""Default rate of control, in Hz."""

SCRIPT_FAILED = 1
"""Exit status after a control script has failed for some robot."""


def add_law_arguments(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Add the options that choose a control law and its gains; returns their group."""
    group = parser.add_argument_group('control law')
    group.add_argument(
        '--algo',
        required=True,
        metavar='NAME',
        help='control script: a path, NAME.py in this folder, or a built-in (see setcmas list)',
    )
    group.add_argument(
        '--exercise',
        action='store_true',
        help='let --algo NAME mean the exercise of that name, with its maths left to fill in',
    )
    group.add_argument(
        '--set',
        action='append',
        default=[],
        metavar='NAME=VALUE',
        help='value of a module-level name of the script, such as kp=1.2; what the script '
        'derives from it follows; may be repeated',
    )
    group.add_argument(
        '--vnom',
        type=positive,
        default=VNOM,
        metavar='M/S',
        help='largest speed of a robot (default: %(default)g m/s)',
    )
    group.add_argument(
        '--komega',
        type=positive,
        default=KOMEGA,
        metavar='GAIN',
        help='gain on the heading error (default: %(default)g 1/s)',
    )
    group.add_argument(
        '--rate',
        type=rate,
        default=RATE_HZ,
        metavar='HZ',
        help='rate of control (default: %(default)g)',
    )
    group.add_argument(
        '--seed',
        type=seed,
        default=SEED,
        metavar='N',
        help='seed of the random numbers that scripts draw (default: %(default)s)',
    )
    return group


def add_watch_argument(group: argparse._ArgumentGroup) -> None:
    """Add --watch."""
    group.add_argument(
        '--watch',
        action='store_true',
        help='load the script again whenever it is saved: fresh state, t = 0, robots where they '
        'are (in experiments only while paused)',
    )


def add_fleet_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options that say which robots are controlled, and how they listen."""
    group = parser.add_argument_group('fleet')
    group.add_argument(
        '--nb-robots',
        type=count,
        metavar='N',
        help='size of the fleet (default: found by its odometry)',
    )
    group.add_argument(
        '--robots', metavar='LIST', help="control only these robots of it, such as '1-4'"
    )
    group.add_argument(
        '--cmd-vel-type',
        choices=(AUTO, *CMD_VEL_TYPES),
        default=AUTO,
        help='message type of cmd_vel (default: %(default)s, what each robot listens to)',
    )


def controlled_robots(args: argparse.Namespace, nb_robots: int) -> list[int]:
    """Return the robots that this process controls, of a fleet of nb_robots.

    Raises:
        SetcmasError: --robots names a robot that is not in the fleet.
    """
    robots = parse_robots(args.robots) if args.robots else list(range(1, nb_robots + 1))
    if robots[-1] > nb_robots:
        raise SetcmasError(
            f"--robots '{args.robots}' names robot {robots[-1]}; "
            f'the fleet has robots 1 to {nb_robots}'
        )
    return robots
