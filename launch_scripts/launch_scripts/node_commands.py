"""Command lines of the node processes."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

SIMULATOR = 'setcmas_simu.simulator.simulator'
CONTROLLER = 'setcmas_ctrl.controllers.controllers'
CAMERA = 'setcmas_expe.mocap.camera_node'
EMULATED_LAB = 'setcmas_expe.emulation.emulated_lab'
BRIDGES = 'setcmas_expe.bridges'
PAUSE = 'setcmas_expe.pause.pause_node'
JOYSTICK_READER = 'setcmas_expe.pause.joystick_reader'
DOCTOR = 'setcmas_expe.doctor.doctor_process'
RECORDER = 'setcmas_tools.bags.recorder'
PLAYER = 'setcmas_tools.bags.player'
BROWSER_VIEW = 'setcmas_tools.page.viewer'

PAGE = 'view'
"""Name of the process that serves the page."""

_RUN_MODULE = (
    'import runpy, sys; del sys.path[0]; '
    "runpy.run_module(sys.argv.pop(1), run_name='__main__', alter_sys=True)"
)


def add_ros_arguments(parser: argparse.ArgumentParser) -> None:
    """Add `--ros-args`, the last option: all arguments after it go to the node process."""
    parser.add_argument(
        '--ros-args',
        nargs=argparse.REMAINDER,
        default=[],
        metavar='...',
        help='arguments for ROS, such as -r __ns:=/a, -p vnom:=0.3 or --params-file gains.yaml',
    )


def ros_arguments(args: argparse.Namespace) -> list[str]:
    """Return the ROS arguments for the node process."""
    return ['--ros-args', *args.ros_args] if args.ros_args else []


def namespace_rule(command: Sequence[str]) -> list[str]:
    """Return ROS arguments that move another process to the namespace in a command, if any."""
    rules = [word for word in command if word.startswith('__ns:=')]
    return ['--ros-args', '-r', rules[-1]] if rules else []


def node_command(module: str, arguments: Sequence[str] = ()) -> list[str]:
    """Return the command line that runs a module of nodes."""
    # Without the current folder in the search path: a student's random.py would hide Python's.
    # Python 3.10 has no option for that.
    run_module = ['-P', '-m'] if sys.version_info >= (3, 11) else ['-c', _RUN_MODULE]
    return [sys.executable, *run_module, module, *arguments]
