"""Let something go wrong in an emulated lab (setcmas expe --emulate), to see the robots stop.

Examples:
  setcmas fault dropout --robot 2 --for 3     motion capture loses tb3_2 for 3 s
  setcmas fault swap                          tb3_1 is taken for tb3_2, and the other way round
  setcmas fault push --robot 4 --for 5        somebody pushes tb3_4 out of the arena
"""

from __future__ import annotations

import argparse

from launch_scripts.processes.environment import local_environment, require_ros
from launch_scripts.processes.node_commands import INJECT_FAULT, node_command
from launch_scripts.processes.run_to_end import run_to_end
from setcmas_expe.emulation.faults import DEFAULT_S, PURPOSES
from setcmas_simu.options import count, positive


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    kinds = '\n'.join(f'  {kind:10}{purpose}' for kind, purpose in PURPOSES.items())
    parser.epilog = f'faults:\n{kinds}'
    parser.add_argument('kind', choices=list(PURPOSES), metavar='FAULT', help='see below')
    parser.add_argument(
        '--robot', type=count, default=1, metavar='I', help='which robot (default: %(default)s)'
    )
    parser.add_argument(
        '--for',
        dest='seconds',
        type=positive,
        default=DEFAULT_S,
        metavar='S',
        help='how long, in s (default: %(default)g)',
    )


def main(args: argparse.Namespace) -> int:
    """Order the fault; returns the exit status."""
    require_ros()
    order = [args.kind, str(args.robot), str(args.seconds)]
    return run_to_end(node_command(INJECT_FAULT, order), local_environment())
