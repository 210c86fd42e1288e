"""The node processes: their command lines, and those of a run with its recorder."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from launch_scripts.environment import local_environment
from launch_scripts.supervisor import Child, Supervisor
from setcmas_ctrl.laws.control_options import ControllerOptions
from setcmas_simu.reports import Paused, Ready, Recording, Started
from setcmas_simu.script_calls import Function, ScriptCall, ScriptFailure
from setcmas_simu.simulation_options import SimulationOptions
from setcmas_tools.run.run_info import Outcome
from setcmas_tools.run.scenario import Scenario

SIMULATOR = 'setcmas_simu.simulator'
CONTROLLER = 'setcmas_ctrl.controllers.controller_processes'
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


def run_in_foreground(
    name: str,
    command: Sequence[str],
    companions: Sequence[tuple[str, Sequence[str]]] = (),
) -> int:
    """Run a process, and its companions if any, until Ctrl-C; return the exit status.

    Topics stay on this machine, and the process must not end by itself.
    """
    with Supervisor(local_environment(), prefix=bool(companions)) as supervisor:
        child = supervisor.start(name, command)
        for companion, its_command in companions:
            supervisor.start(companion, its_command, needed=False)
        return supervisor.run_to_end(child, may_end=False)


class RecordedRun:
    """A run and its recorder; subclasses add the other processes.

    Attributes:
        recorder: Process that writes the bag.
        status: Exit status of the controllers, after `finish`.
        failed: Script calls that failed or hung, after `finish`.
        failures: Periods in which laws and conditions failed, after `finish`.
    """

    def __init__(self, supervisor: Supervisor, bag: Path, rtf: float = 1.0) -> None:
        self.status = 0
        self.failed: tuple[ScriptCall, ...] = ()
        self.failures: tuple[ScriptFailure, ...] = ()
        self._supervisor = supervisor
        recorder = node_command(RECORDER, ['--output', str(bag), '--rtf', str(rtf)])
        self.recorder = supervisor.start('record', recorder)

    def elapsed(self, wall_s: float) -> float:
        """Return the run's own elapsed time, `wall_s` s after its start."""
        return wall_s


class SimulatedRun(RecordedRun):
    """Recorder, simulator and controllers.

    Attributes:
        trouble: Problem with the robots while all processes run; none in simulation.
        is_stuck: Whether robots stay paused for good; never in simulation.
    """

    trouble = ''
    is_stuck = False

    def __init__(self, supervisor: Supervisor, scenario: Scenario, bag: Path) -> None:
        given = SimulationOptions.among(scenario.values())
        simulation = replace(given, nb_robots=scenario.nb_robots)
        super().__init__(supervisor, bag, simulation.rtf)
        self._rtf = simulation.rtf
        robots = node_command(SIMULATOR, simulation.arguments())
        self._simulator = supervisor.start('simu', robots)
        options = ControllerOptions(
            nb_robots=scenario.nb_robots, model=simulation.model, recorded=True
        )
        self._laws = node_command(CONTROLLER, controller_arguments(scenario, options))
        self._ctrl: Child | None = None

    @property
    def started(self) -> bool:
        """Whether the robots are controlled."""
        return self._ctrl is not None and self._ctrl.reported(Started) is not None

    @property
    def paused(self) -> bool:
        """Whether the robots are paused."""
        report = self._ctrl.reported(Paused) if self._ctrl else None
        return report is not None and report.paused

    def elapsed(self, wall_s: float) -> float:
        """Return the run's own elapsed time, `wall_s` s after its start."""
        return wall_s * self._rtf

    @property
    def missing(self) -> str:
        """Why the run has not started yet."""
        if not self._ctrl:
            return 'the simulator is not ready'
        if not self.recorder.reported(Recording):
            return 'the recorder has not found the topics of all robots'
        return self._ctrl.missing

    def tick(self) -> None:
        """Start the controllers once the simulator has announced its robots.

        A simulator that refuses to start, because another has these robots, announces nothing.
        """
        if not self._ctrl and self._simulator.reported(Ready):
            self._ctrl = self._supervisor.start('ctrl', self._laws)

    def finish(self) -> None:
        """Stop the controllers."""
        assert self._ctrl
        self._supervisor.stop(self._ctrl)
        robots = self._simulator.failed
        self.status = self._ctrl.exit_status or int(robots != ())
        self.failed = self._ctrl.failed + robots
        self.failures = self._ctrl.failures

    def stop(self) -> None:
        """Stop all, controllers first: the bag must contain their last command, zero."""
        laws = [self._ctrl] if self._ctrl else []
        self._supervisor.stop(*laws, self.recorder, self._simulator)


def controller_arguments(scenario: Scenario, options: ControllerOptions) -> list[str]:
    """Return the arguments of a controller process."""
    return scenario.law.arguments(scenario.communication, scenario.safety, options)


def outcome_of(failed: Sequence[ScriptCall]) -> Outcome:
    """Return the outcome of a run from the calls that failed."""
    laws: dict[str, list[int]] = {}
    conditions: dict[str, list[int]] = {}
    for call in sorted(failed, key=lambda call: call.robot):
        scripts = conditions if call.function is Function.CONDITION else laws
        robots = scripts.setdefault(call.script, [])
        if call.robot not in robots:
            robots.append(call.robot)
    return Outcome.of_failures(laws, conditions)
