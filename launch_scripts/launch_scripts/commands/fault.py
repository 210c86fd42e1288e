"""Inject a fault into an emulated lab (setcmas expe --emulate), to see the robots stop.

Examples:
  setcmas fault dropout --robot 2 --for 3     motion capture loses tb3_2 for 3 s
  setcmas fault swap                          motion capture confuses tb3_1 with tb3_2
  setcmas fault push --robot 4 --for 5        a push moves tb3_4 out of the arena
"""

from __future__ import annotations

import argparse
import os
from dataclasses import dataclass

from launch_scripts.environment import local_environment, require_ros
from setcmas_expe.emulation.faults import DEFAULT_S, PURPOSES, Fault, FaultKind, inject
from setcmas_simu.option_groups import Options, option
from setcmas_simu.option_kinds import DURATION, Whole


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
    os.environ.update(local_environment())  # where `setcmas expe --emulate` is, before ROS starts
    options = FaultOptions.of(args)
    inject(Fault(FaultKind[args.kind.upper()], options.robot, options.seconds))
    return 0
