"""Options that choose the lab of an experiment, for all its processes."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from pathlib import Path

from setcmas_expe.arena import Arena
from setcmas_expe.lab.file import DEFAULT_FILE, load_lab
from setcmas_expe.lab.model import Lab, Mocap
from setcmas_expe.mocap.sources import MOCAP_SOURCES
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import AUTO, CMD_VEL_TYPES
from setcmas_simu.options import count, positive
from setcmas_simu.robots.velocity_limits import ROBOT_MODELS

LAB_OPTIONS = (
    'lab',
    'nb_robots',
    'mocap',
    'limits',
    'arena',
    'min_separation',
    'cmd_vel_type',
    'joystick_button',
)
"""Names of the options that `add_lab_arguments` adds."""


def add_lab_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of a lab; what they say goes before the lab file."""
    group = parser.add_argument_group('lab')
    group.add_argument(
        '--lab', type=Path, metavar='FILE', help='lab file (default: the one that comes with this)'
    )
    group.add_argument(
        '--nb-robots',
        type=count,
        metavar='N',
        help="size of the fleet (default: the lab file's, or 1)",
    )
    group.add_argument('--mocap', metavar='NAME', help='motion capture driver (see setcmas list)')
    group.add_argument('--limits', choices=list(ROBOT_MODELS), help='how fast robots are driven')
    group.add_argument('--arena', metavar='XMIN,XMAX,YMIN,YMAX', help='where robots may be (m)')
    group.add_argument(
        '--min-separation', type=positive, metavar='M', help='between two robots, in m'
    )
    group.add_argument(
        '--cmd-vel-type', choices=(AUTO, *CMD_VEL_TYPES), help='what the robots listen to'
    )
    group.add_argument(
        '--joystick-button', type=int, metavar='B', help='starts and pauses, counted from 0'
    )


def chosen_lab(args: argparse.Namespace) -> Lab:
    """Return the lab that parsed options describe.

    Raises:
        SetcmasError: The lab file has a mistake, or an option makes no sense.
    """
    lab = load_lab(args.lab or DEFAULT_FILE, args.nb_robots)
    if args.mocap:
        lab = replace(lab, mocap=_mocap(args.mocap, lab))
    if args.limits:
        lab = replace(lab, limits=ROBOT_MODELS[args.limits])
    if args.arena:
        lab = replace(lab, arena=_arena(args.arena))
    if args.joystick_button is not None and args.joystick_button < 0:
        raise SetcmasError(
            f'--joystick-button is {args.joystick_button}; it must be a whole number from 0'
        )
    given = {
        name: value
        for name in ('min_separation', 'cmd_vel_type', 'joystick_button')
        if (value := getattr(args, name)) is not None
    }
    return replace(lab, **given)


def _mocap(name: str, lab: Lab) -> Mocap:
    source = MOCAP_SOURCES.get(name)
    for robot in lab.robots:
        if not source.may_name(robot.mocap_name):
            raise SetcmasError(
                f"--mocap {name}: mocap_name '{robot.mocap_name}' must be letters, digits and _ "
                f'to be part of the topic {source.topic}'
            )
    return replace(lab.mocap, preset=name, source=source)


def _arena(text: str) -> Arena:
    try:
        arena = Arena(*map(float, text.split(',')))
    except (TypeError, ValueError):
        arena = Arena(0.0, 0.0, 0.0, 0.0)
    finite = all(map(math.isfinite, (arena.xmin, arena.xmax, arena.ymin, arena.ymax)))
    if not (finite and arena.xmin < arena.xmax and arena.ymin < arena.ymax):
        raise SetcmasError(
            f"--arena '{text}' is not understood; it must be XMIN,XMAX,YMIN,YMAX in m with the "
            'smaller ones first, such as --arena=-2,2,-1.5,1.5'
        )
    return arena
