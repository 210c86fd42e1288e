"""Drive real TurtleBot3s under motion capture with a control law, until q or Ctrl-C.

The experiment starts paused: s starts it, the space bar pauses it, Esc or e is an emergency stop.
It pauses itself, until somebody starts it again, when something that it depends on falls silent.

Examples:
  setcmas expe --emulate --algo nav_wp           rehearse without any hardware
  setcmas expe --lab lab.yaml --algo consensus
  setcmas expe --mocap vicon --nb-robots 8 --algo consensus
"""

from __future__ import annotations

import argparse
import sys
import time

from launch_scripts.commands.view_options import NONE, ViewOptions, view_beside
from launch_scripts.processes.child_process import ChildDiedError
from launch_scripts.processes.environment import require_ros
from launch_scripts.processes.experiment import (
    Experiment,
    experiment_environment,
    joystick_command,
)
from launch_scripts.processes.rviz import Companion
from launch_scripts.processes.supervisor import StoppedError, Supervisor
from launch_scripts.terminal.keyboard import ESC, Keyboard, StartKey, single_keys
from launch_scripts.terminal.status_display import KEYS, StatusDisplay
from launch_scripts.terminal.terminal_output import warn
from setcmas_ctrl.communication.communication_options import CommunicationOptions
from setcmas_ctrl.communication.communication_settings import check_communication
from setcmas_ctrl.control.control_options import LawOptions
from setcmas_ctrl.filter.clearance import check_starts
from setcmas_ctrl.filter.filter_options import OF_LAB, FilterOptions
from setcmas_expe.emulation.emulation_options import (
    EmulationOptions,
    check_emulated_mocap,
    emulated_start_poses,
)
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_options import LabOptions
from setcmas_expe.pause.console import Action
from setcmas_simu.errors import SetcmasError

_STOPS = {
    ESC: (Action.EMERGENCY, 'by Esc'),
    'e': (Action.EMERGENCY, 'by e'),
    ' ': (Action.PAUSE, 'by space bar'),
}
"""Of several that come at once the first counts: what stops, stops."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    LawOptions.add_to(parser)
    CommunicationOptions.add_to(parser)
    LabOptions.add_to(parser)
    FilterOptions.add_to(parser, without=OF_LAB)
    parser.add_argument(
        '--hold',
        action='store_true',
        help="robots move only while s, the joystick's button or the page's button is held",
    )
    parser.add_argument('--no-joystick', action='store_true', help='do not look for a joystick')
    group = parser.add_argument_group('emulated lab')
    group.add_argument(
        '--emulate', action='store_true', help='no hardware: an emulated lab on this machine'
    )
    EmulationOptions.add_to(
        parser, without=('seed', 'mocap_rate', 'robot_cmd_vel_type', 'remapped')
    )
    ViewOptions.add_to(parser, view=NONE)


def main(args: argparse.Namespace) -> int:
    """Run the experiment; returns the exit status."""
    law = LawOptions.of(args)
    scripts = law.scripts()  # mistakes are told before anything starts
    lab = LabOptions.of(args).chosen()
    safety = lab.safety(FilterOptions.of(args))
    lab.check_rate(law.rate)
    scripts.check(lab.nb_robots)
    for note in scripts.notes:
        warn(f'setcmas expe: {note}')
    check_communication(CommunicationOptions.of(args).found(law.exercise), lab.nb_robots)
    poses = EmulationOptions.of(args)
    if args.emulate:
        poses.robot_model([robot.number for robot in lab.robots])
        check_emulated_mocap(lab.mocap)
        check_starts(safety, emulated_start_poses(lab.arena, lab.nb_robots, poses))
    elif poses.poses or poses.pose or poses.random_poses or poses.model:
        raise SetcmasError('start poses and --model are for emulated robots: add --emulate')
    require_ros()
    lab.mocap.source.message_class()
    environment = experiment_environment(lab, args.emulate)
    numbers = [robot.number for robot in lab.robots]
    with (
        view_beside(ViewOptions.of(args), numbers, experiment=True) as views,
        Keyboard() as keyboard,
        Supervisor(environment, prefix=True) as supervisor,
    ):
        display = StatusDisplay(supervisor.stdout)
        supervisor.write = lambda line, _: display.write(line)
        try:
            return _run(supervisor, keyboard, display, lab, args, views)
        finally:
            display.close()


def _run(
    supervisor: Supervisor,
    keyboard: Keyboard,
    display: StatusDisplay,
    lab: Lab,
    args: argparse.Namespace,
    views: list[Companion],
) -> int:
    joystick = None if args.no_joystick else joystick_command(lab.joystick_topic)
    try:
        experiment = Experiment(
            supervisor, lab, args, LabOptions.of(args), hold=args.hold, joystick=joystick
        )
    except StoppedError:
        return 0
    except ChildDiedError as death:
        if str(death):
            supervisor.warn(f'setcmas expe: {death}')
        return death.exit_status
    experiment.on_status = display.show
    for name, command in views:
        supervisor.start(name, command, needed=False)
    ways = ['s'] if keyboard.there else []
    ways += [f'button {lab.joystick_button} of the joystick'] if joystick else []
    _explain(supervisor, ways, keyboard.there, args.hold)

    start_key = StartKey(args.hold)

    def serve_terminal() -> None:
        display.note_silence()
        pressed = keyboard.pressed()
        keys = single_keys(pressed).lower()
        starts = start_key.pressed(pressed, time.monotonic())
        if 'q' in keys:
            raise StoppedError
        experiment.request(*next((_STOPS[key] for key in _STOPS if key in keys), (Action.ALIVE,)))
        if pressed and set(pressed) == {'R'}:
            for _ in pressed:  # more than one: it is held down
                experiment.request(Action.RELEASE)
        elif starts:
            experiment.request(Action.START, 'by s')

    try:
        supervisor.run(on_tick=serve_terminal)
    except StoppedError:
        experiment.on_status = lambda _: None  # what was measured last is no state any more
        status = experiment.stop()
        experiment.stop_lab()
        if experiment.runaways:
            names = ', '.join(sorted(experiment.runaways))
            supervisor.warn(f'setcmas expe: {names} did not stop when commanded zero')
            return 1
        return status
    except ChildDiedError as death:
        if str(death):
            supervisor.warn(f'setcmas expe: {death}; everything is stopped')
        experiment.stop()
        return death.exit_status
    return 0


def _explain(supervisor: Supervisor, ways: list[str], has_keys: bool, hold: bool) -> None:
    """Say what starts the robots."""
    starts = 'starts the robots, for as long as it is held' if hold else 'starts the robots'
    if ways:
        supervisor.warn(f'paused; {" or ".join(ways)} {starts} ({KEYS})')
    if not has_keys and sys.stdin is not None:
        nothing = '' if ways else ': nothing starts the robots but a joystick, or --view'
        supervisor.warn(f'there is no terminal to read keys from{nothing}')
