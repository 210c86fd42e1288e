"""The processes of an experiment: started together, stopped in the order that robots need."""

from __future__ import annotations

import argparse
import importlib.util
import os
from collections.abc import Sequence
from pathlib import Path

from launch_scripts.processes.child_process import Child
from launch_scripts.processes.environment import closed_environment, lab_environment
from launch_scripts.processes.node_arguments import node_arguments
from launch_scripts.processes.node_commands import (
    BRIDGES,
    CONTROLLER,
    CONTROLLER_OPTIONS,
    EMULATED_LAB,
    JOYSTICK_READER,
    PAUSE,
    node_command,
)
from launch_scripts.processes.supervisor import Supervisor
from launch_scripts.terminal.output_lines import Stream
from launch_scripts.terminal.status_display import StatusDisplay
from setcmas_expe.lab.model import Lab
from setcmas_expe.lab.options import LAB_OPTIONS
from setcmas_expe.pause import console_protocol

_EMULATION_OPTIONS = ('poses', 'pose', 'seed')
_CTRL_OPTIONS = tuple(
    name for name in CONTROLLER_OPTIONS if name not in ('nb_robots', 'robots', 'cmd_vel_type')
)
_TAKE_OVER_S = 0.5


def experiment_environment(lab: Lab, emulated: bool) -> dict[str, str]:
    """Return the environment of an experiment's processes: an emulated lab is on this machine."""
    if emulated:
        return closed_environment()
    return lab_environment(lab.static_peers, lab.discovery_server)


class Experiment:
    """The bridge, pause and controller processes, and an emulated lab if wanted."""

    def __init__(
        self,
        supervisor: Supervisor,
        lab: Lab,
        args: argparse.Namespace,
        lab_options: Sequence[str] = LAB_OPTIONS,
        recorded: bool = False,
    ) -> None:
        """Start the processes.

        Args:
            supervisor: Watches them.
            lab: The lab.
            args: Parsed options of `setcmas expe` or `setcmas run`.
            lab_options: Names of those that describe the lab.
            recorded: Whether the controllers wait for a recorder.
        """
        self._supervisor = supervisor
        self._stopped = False
        self._emulated: list[Child] = []
        if args.emulate:
            command = node_command(EMULATED_LAB, emulation_arguments(args, lab_options))
            self._emulated = [supervisor.start('lab', command)]
        options = node_arguments(args, lab_options)
        self._bridges = supervisor.start('bridge', node_command(BRIDGES, options))
        pause = node_command(PAUSE, [*options, '--console'])
        self._pause = supervisor.start('pause', pause, listens=True)
        laws = ['--experiment', '--nb-robots', str(lab.nb_robots)]
        laws += ['--pause-timeout', str(lab.timeouts.pause_s)]
        laws += ['--recorded'] if recorded else []
        laws += node_arguments(args, _CTRL_OPTIONS)
        self._ctrl = supervisor.start('ctrl', node_command(CONTROLLER, laws))

    def start_joystick(self, command: list[str]) -> None:
        """Start the process that reads a joystick."""
        self._supervisor.start('joystick', command, needed=False)

    def toggle(self) -> None:
        """Start if paused, else pause."""
        self._pause.tell(console_protocol.TOGGLE)

    def pause(self) -> None:
        """Pause, whatever is now."""
        self._pause.tell(console_protocol.PAUSE)

    def go(self) -> None:
        """Start."""
        self._pause.tell(console_protocol.GO)

    def keep_alive(self) -> None:
        """Tell the pause process that somebody serves the keyboard; several times a second."""
        self._pause.tell(console_protocol.ALIVE)

    def stop(self) -> int:
        """Stop the robots, then all processes; returns the exit status of the controllers.

        To be called again does no harm.
        """
        if self._stopped:
            return self._ctrl.process.returncode
        self._stopped = True
        if self._bridges.running():
            self._pause.tell(console_protocol.END)
            self._supervisor.stop(self._bridges)
        else:
            self._pause.tell(console_protocol.HALT)
            self._supervisor.wait(_TAKE_OVER_S)
        self._supervisor.stop(self._ctrl, self._pause)
        return self._ctrl.process.returncode

    def stop_lab(self) -> None:
        """Stop the emulated lab, after whatever records it."""
        self._supervisor.stop(*self._emulated)


def emulation_arguments(args: argparse.Namespace, lab_options: Sequence[str]) -> list[str]:
    """Return the command line of the emulated lab for a command's parsed options."""
    own = [name for name in _EMULATION_OPTIONS if hasattr(args, name)]
    return node_arguments(args, (*lab_options, *own))


def shown(display: StatusDisplay, line: str, _: Stream) -> None:
    """Show a line of output, or the status that is in it."""
    status = console_protocol.decode(line)
    if status is None:
        display.write(line)
    else:
        display.show(status)


def joystick_command(topic: str) -> list[str] | None:
    """Return the command that reads a joystick: joy_node where ROS's joy package is installed.

    Returns:
        The command; None where neither joy nor pygame is installed.
    """
    remap = ['--ros-args', '-r', f'joy:={topic}']
    for prefix in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep):
        executable = Path(prefix) / 'lib' / 'joy' / 'joy_node'
        if prefix and executable.is_file():
            return [str(executable), *remap]
    if importlib.util.find_spec('pygame'):
        return node_command(JOYSTICK_READER, remap)
    return None
