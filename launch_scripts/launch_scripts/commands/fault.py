"""Inject a fault into an emulated lab (setcmas expe --emulate), to see the robots stop.

Examples:
  setcmas fault dropout --robot 2 --for 3     motion capture loses tb3_2 for 3 s
  setcmas fault swap                          motion capture confuses tb3_1 with tb3_2
  setcmas fault push --robot 4 --for 5        a push moves tb3_4 out of the arena
"""

from __future__ import annotations

import argparse
import signal
from dataclasses import dataclass

from launch_scripts.processes.environment import local_environment, require_ros
from launch_scripts.processes.node_commands import INJECT_FAULT, node_command
from launch_scripts.processes.supervisor import run_to_end
from launch_scripts.terminal.terminal_output import warn
from setcmas_expe.emulation.faults import DEFAULT_S, PURPOSES
from setcmas_simu.options.group import Options, option
from setcmas_simu.options.kinds import DURATION, Whole


@dataclass(frozen=True, kw_only=True)
class FaultOptions(Options):
    """Robot and duration of a fault."""

    robot: int = option(Whole(1, metavar='I'), 'affected robot', default=1)
    seconds: float = option(DURATION, 'duration', default=DEFAULT_S, flag='--for')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    kinds = '\n'.join(f'  {kind:12}{purpose}' for kind, purpose in PURPOSES.items())
    parser.epilog = f'faults:\n{kinds}'
    parser.add_argument('kind', choices=list(PURPOSES), metavar='FAULT', help='see below')
    FaultOptions.add_to(parser)


def main(args: argparse.Namespace) -> int:
    """Request the fault; return the exit status."""
    require_ros()
    options = FaultOptions.of(args)
    order = [args.kind, str(options.robot), str(options.seconds)]
    status = run_to_end(node_command(INJECT_FAULT, order), local_environment())
    if status == 128 + signal.SIGALRM:
        warn('setcmas fault: ROS did not answer in time; the fault may be missing')
    return status
