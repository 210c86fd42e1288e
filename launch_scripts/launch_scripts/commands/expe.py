"""Drive real TurtleBot3s under motion capture with a control law, until q or Ctrl-C.

The experiment starts paused: s starts it, the space bar pauses it, Esc or e stops it.
If poses, commands or the operator's pause node are missing, it pauses until you press s again.
With --emulate and --duration or --output it starts, records and ends by itself.

Examples:
  setcmas expe square.yaml --emulate
  setcmas expe --emulate --algo nav_wp           rehearse without any hardware
  setcmas expe --emulate --algo nav_wp --duration 60 -o out     starts, records and ends by itself
  setcmas expe --lab lab.yaml --algo consensus
  setcmas expe --mocap vicon --nb-robots 8 --algo consensus
"""

from __future__ import annotations

import argparse
import math
import time
from dataclasses import asdict

from launch_scripts.command_scenario import (
    add_scenario_arguments,
    scenario_of,
    typed_values,
)
from launch_scripts.commands.run import concluded, new_run
from launch_scripts.commands.view import NONE, ViewOptions, fleet_views
from launch_scripts.environment import require_ros
from launch_scripts.experiment import (
    Experiment,
    experiment_environment,
    joystick_command,
)
from launch_scripts.processes import ChildDiedError
from launch_scripts.recorded_run import ProgressSupervisor, RecordedExperiment, run_robots
from launch_scripts.status_display import KEYS, StatusDisplay
from launch_scripts.supervisor import StoppedError, Supervisor
from launch_scripts.terminal import (
    Keyboard,
    StartKey,
    Stream,
    open_operator_keyboard,
    single_key_terminal,
    single_keys,
    warn,
)
from setcmas_ctrl.laws.control_options import WatchOptions
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_file import LabOptions
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.plots.plot_options import PlotOptions
from setcmas_tools.run.run_folder import RunOptions
from setcmas_tools.run.scenario import Scenario, options
from setcmas_tools.run.scenario_lab import bounded_lab_options, check_emulated, in_lab

_ONLY_STOPS = 'not started: over ssh this key only counts while your terminal answers'

_OF_SIMULATED_ROBOTS = ('cmd_timeout', 'robot_rate', 'rtf')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    RunOptions.add_to(parser)
    PlotOptions.add_to(parser, without=('show',))
    parts = ('time', 'law', 'communication', 'safety', 'robots', 'lab')
    add_scenario_arguments(parser, without=_OF_SIMULATED_ROBOTS, parts=parts)
    WatchOptions.add_to(parser)
    of_scenario = [name for name in LabOptions.options() if name in options()]
    LabOptions.add_to(parser, without=of_scenario)
    hold = (
        'robots move only while you hold down s or the button of a wired joystick (a wireless one '
        'keeps its last state when its battery dies)'
    )
    parser.add_argument('--hold', action='store_true', help=hold)
    parser.add_argument('--no-joystick', action='store_true', help='do not look for a joystick')
    ViewOptions.add_to(parser, view=NONE)


def main(args: argparse.Namespace) -> int:
    """Run the experiment; return the exit status."""
    scenario = scenario_of(args)
    of_lab = _lab_options(args, scenario)
    lab = of_lab.chosen()
    _check(args, scenario, lab)
    for note in scenario.notes:
        warn(f'setcmas expe: {note}')
    require_ros()
    lab.mocap.source.message_class()
    if _is_recorded(args):
        return _record(args, in_lab(scenario, lab), of_lab, lab)
    environment = experiment_environment(lab, scenario.lab.emulate)
    numbers = [robot.number for robot in lab.robots]
    joystick = None if args.no_joystick else joystick_command(lab.joystick_topic)
    with (
        fleet_views(ViewOptions.of(args), numbers, experiment=True) as views,
        open_operator_keyboard(
            args.hold and joystick is not None, scenario.lab.emulate
        ) as keyboard,
        DisplaySupervisor(environment, prefix=True) as supervisor,
    ):
        if not keyboard.there and not joystick:
            raise SetcmasError(
                'there is no terminal and no joystick: nothing could start the robots'
            )
        try:
            if lab.mocap.source.from_start:
                _confirm_starts(supervisor, keyboard, lab)
            experiment = Experiment(
                supervisor,
                scenario,
                of_lab,
                supervisor.display.show,
                hold=args.hold,
                watch=args.watch,
                joystick=joystick,
            )
            for name, command in views:
                supervisor.start(name, command, needed=False)
            ways = ['s'] if keyboard.there and not keyboard.only_stops else []
            ways += [f'button {lab.joystick_button} of the joystick'] if joystick else []
            _explain(supervisor, ways, keyboard.there, args.hold)
            return _serve(supervisor, keyboard, experiment, args.hold)
        except StoppedError:
            return 0
        except ChildDiedError as death:
            return supervisor.report_death(death, 'expe')
        finally:
            supervisor.display.close()


class DisplaySupervisor(Supervisor):
    """Supervisor that writes above the state of the robots.

    Attributes:
        display: It shows that state.
    """

    def __init__(self, environment: dict[str, str], prefix: bool = False) -> None:
        """Prepare, as every supervisor."""
        super().__init__(environment, prefix)
        self.display = StatusDisplay(self.stdout)

    def write(self, line: str, stream: Stream) -> None:
        """Write a line of output, whichever stream it is for."""
        del stream
        self.display.write(line)


def _lab_options(args: argparse.Namespace, scenario: Scenario) -> LabOptions:
    """Return the options of the lab; a scenario file tightens what the lab file sets."""
    typed = typed_values(args)
    if args.scenario and not scenario.lab.emulate and scenario.lab.lab and 'lab' not in typed:
        raise SetcmasError(f"'{args.scenario}' names a lab; in experiments add --lab instead")
    return bounded_lab_options(scenario, typed, args.scenario is not None)


def _check(args: argparse.Namespace, scenario: Scenario, lab: Lab) -> None:
    scenario.replace(nb_robots=lab.nb_robots).check()
    lab.check_rate(scenario.law.rate)
    if scenario.lab.emulate:
        check_emulated(scenario, lab)
    elif {'poses', 'pose', 'random_poses', 'model'} & typed_values(args).keys():
        raise SetcmasError('start poses and --model are for emulated robots: add --emulate')
    elif _is_recorded(args):
        raise SetcmasError(
            '--duration and --output start robots by themselves, which only emulated robots may '
            'do: add --emulate, or record real robots with setcmas record'
        )
    if args.hold and _is_recorded(args):
        raise SetcmasError(
            '--hold needs a person who holds s; leave it out where robots start by themselves '
            '(--duration, --output)'
        )


def _is_recorded(args: argparse.Namespace) -> bool:
    """Return whether the experiment starts, records and ends by itself."""
    return 'duration' in typed_values(args) or args.output is not None


def _record(args: argparse.Namespace, scenario: Scenario, of_lab: LabOptions, lab: Lab) -> int:
    """Run an emulated experiment for its duration, and record it; return the exit status."""
    of_lab_file = {'limits': asdict(lab.limits), 'robot_rate': None}
    folder, info = new_run(args, scenario, of_lab_file)
    robots = [robot.number for robot in lab.robots]
    with (
        fleet_views(ViewOptions.of(args), robots, experiment=True) as views,
        single_key_terminal() as there,
        ProgressSupervisor(experiment_environment(lab, emulated=True), prefix=True) as supervisor,
    ):
        keyboard = Keyboard(there)
        if there:
            supervisor.warn('the robots start by themselves; Esc or space ends the run, so does q')

        def serve(experiment: Experiment) -> None:
            experiment.stop_by_keys(single_keys(keyboard.pressed()).lower(), attended=True)

        def start() -> RecordedExperiment:
            bag = folder.bag
            return RecordedExperiment(supervisor, scenario, bag, of_lab, args.watch, serve)

        duration = scenario.time.duration
        status, ended = run_robots('expe', supervisor, start, duration, folder, info, views)
    return concluded(args, folder, ended, None, status)


def _confirm_starts(supervisor: Supervisor, keyboard: Keyboard, lab: Lab) -> None:
    """Wait until the operator confirms the start poses: the robots' wheels cannot measure them.

    Raises:
        SetcmasError: There is no keyboard.
        StoppedError: The operator stopped the command.
    """
    if not keyboard.there:
        raise SetcmasError(
            f'{lab.mocap.preset} needs a person at a terminal, who confirms the start poses'
        )
    places = [
        f'{robot_name(robot.number)} at ({x:g}, {y:g}) m, heading {math.degrees(theta):.0f} deg'
        for robot in lab.robots
        for x, y, theta in [robot.start or (math.nan,) * 3]
    ]
    supervisor.warn(
        f'{lab.mocap.preset} counts from these start poses: {"; ".join(places)}; press y once '
        'every robot stands there (q: quit)'
    )
    pressed: set[str] = set()
    supervisor.run(
        until=lambda: bool(pressed & {'y', 'q'}),
        on_tick=lambda: pressed.update(keyboard.pressed().lower()),
    )
    if 'q' in pressed:
        raise StoppedError


def _serve(
    supervisor: DisplaySupervisor, keyboard: Keyboard, experiment: Experiment, hold: bool
) -> int:
    """Serve the operator until the end of the experiment; return the exit status."""
    start_key = StartKey(hold)

    def serve_terminal() -> None:
        supervisor.display.note_silence()
        pressed = keyboard.pressed()
        experiment.stop_by_keys(single_keys(pressed).lower(), keyboard.is_attended)
        if keyboard.only_stops:
            if set(pressed) & set('sSR'):
                supervisor.warn(_ONLY_STOPS)
            pressed = ''
        starts = start_key.pressed(pressed, time.monotonic())
        releases = len(pressed) if set(pressed) == {'R'} else 0
        experiment.start_by_keys(starts and not releases, releases)

    try:
        supervisor.run(on_tick=serve_terminal)
    except StoppedError:
        supervisor.display.close()
        status = experiment.stop()
        experiment.stop_lab()
        if experiment.runaways:
            names = ', '.join(sorted(experiment.runaways))
            supervisor.warn(f'setcmas expe: {names} did not stop when commanded zero velocity')
            return 1
        return status
    except ChildDiedError as death:
        status = supervisor.report_death(death, 'expe')
        experiment.stop()
        return status
    return 0


def _explain(supervisor: Supervisor, ways: list[str], has_keys: bool, hold: bool) -> None:
    starts = 'starts the robots once all are ready' + ', for as long as it is held' * hold
    if ways:
        supervisor.warn(f'paused; {" or ".join(ways)} {starts} ({KEYS})')
    if not has_keys:
        supervisor.warn('no terminal to read keys from')
