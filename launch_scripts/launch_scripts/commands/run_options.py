"""Options of a whole run, the same over ROS (`setcmas run`) and offline (`setcmas offline`)."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from launch_scripts.commands.earlier_run import add_from_argument
from launch_scripts.commands.plot_options import FormatOptions
from setcmas_ctrl.communication.communication_options import CommunicationOptions
from setcmas_ctrl.control.control_options import LawOptions
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_expe.lab.lab import Lab
from setcmas_simu.simulator.simulator_options import SimulationOptions
from setcmas_tools.run.run_folder import RunOptions

_OF_ROBOTS = (
    'pose',
    'random_poses',
    'model',
    'limits',
    'robot_rate',
    'poses',
    'cmd_timeout',
    'lockstep',
    'rtf',
)


def add_run_arguments(parser: argparse.ArgumentParser, without: Sequence[str] = ()) -> None:
    """Add the options, without some of the law's or of the simulated robots'."""
    RunOptions.add_to(parser)
    FormatOptions.add_to(parser)
    add_law_arguments(parser, without)
    add_from_argument(parser)


def add_law_arguments(parser: argparse.ArgumentParser, without: Sequence[str] = ()) -> None:
    """Add the options of the law, of communication, filter and simulated robots, without some."""
    LawOptions.add_to(parser, without)
    CommunicationOptions.add_to(parser)
    FilterOptions.add_to(parser)
    given = ('robots', 'cmd_vel_type', 'seed', *without)
    SimulationOptions.add_to(parser, given, nb_robots=1)


def output_folder(args: argparse.Namespace, scripts: LawScripts) -> Path:
    """Return the folder that was asked for, or one named after verb, scripts, date and time."""
    name = scripts.title.replace(', ', '_')
    return args.output or Path(time.strftime(f'{args.verb}_{name}_%Y%m%d-%H%M%S'))


def parameters(
    args: argparse.Namespace, scripts: LawScripts, lab: Lab | None = None
) -> dict[str, Any]:
    """Return what run.yaml records of the options, and of the lab of an emulated experiment."""
    law = LawOptions.of(args)
    values: dict[str, Any] = {'algo': law.algo, 'script': scripts.name, 'set': law.settings}
    values |= {'nb_robots': args.nb_robots, 'duration': args.duration}
    values |= {'vnom': law.vnom, 'komega': law.komega, 'rate': law.rate}
    values |= CommunicationOptions.of(args).record()
    values |= FilterOptions.of(args).record()
    robots = SimulationOptions.of(args).record()
    values |= {name: robots[name] for name in _OF_ROBOTS}
    if not lab:
        return values
    given = ('mocap', 'resume', 'without_guard', 'without_motion_check')
    return values | _of_lab(lab) | {name: getattr(args, name) for name in given}


def _of_lab(lab: Lab) -> dict[str, object]:
    """Return what a lab decides in place of the options of simulated robots."""
    return {
        'limits': asdict(lab.limits),
        'arena': list(lab.arena),
        'min_separation': lab.min_separation,
        'filter': lab.filter,
        'obstacles': str(lab.obstacles) or None,
        'accel': lab.accel if lab.accel < math.inf else None,
        'robot_rate': None,
    }
