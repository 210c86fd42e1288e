"""The processes of `setcmas run`: a recorder, robots, and their controllers."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from launch_scripts.processes.experiment import Experiment
from launch_scripts.processes.law_arguments import law_arguments
from launch_scripts.processes.node_commands import (
    CONTROLLER,
    RECORDER,
    SIMULATOR,
    node_command,
)
from launch_scripts.processes.stand_in import stop_robots_of
from launch_scripts.processes.supervision.child_process import Child, ChildReport
from launch_scripts.processes.supervision.supervisor import Supervisor
from setcmas_ctrl.control.options import ControllerOptions
from setcmas_ctrl.filter.options import FilterOptions
from setcmas_expe.lab.model import Lab
from setcmas_expe.lab.options import LabOptions
from setcmas_expe.pause.console_protocol import Status, Word
from setcmas_simu.reports.reports import (
    Function,
    Paused,
    Reached,
    Ready,
    Recording,
    Reloaded,
    ScriptCall,
    ScriptFailure,
    Started,
)
from setcmas_simu.robots.models import NO_LIMITS
from setcmas_simu.robots.velocity_limits import ROBOT_MODELS, limits_named
from setcmas_simu.simulator.options import SimulationOptions, SimulatorOptions
from setcmas_tools.recorder.options import RecorderOptions
from setcmas_tools.run.outcome import Outcome

_COMES_TO_REST_S = 2.0


def emulated_lab_options(args: argparse.Namespace) -> LabOptions:
    """Return the lab of an emulated run: its file, and the options that override it."""
    limits = args.limits if args.limits in ROBOT_MODELS else None  # by default there are none
    return LabOptions.of(argparse.Namespace(**{**vars(args), 'limits': limits}))


class ReloadTimes:
    """When control scripts were loaded again.

    Attributes:
        on_reload: Takes the time in s since the control laws were called first, and whether the
            new version works.
    """

    def __init__(self, elapsed: Callable[[float], float]) -> None:
        """Begin before the control laws are called; `elapsed` is that of the run."""
        self._elapsed = elapsed
        self._begin = time.monotonic()
        self.on_reload: Callable[[float, bool], None] = lambda _t, _works: None

    def take(self, report: ChildReport) -> None:
        """Take a report of the controllers."""
        if isinstance(report, Started):
            self._begin = time.monotonic()
        elif isinstance(report, Reloaded):
            self.on_reload(self._elapsed(time.monotonic() - self._begin), report.works)


class SimulatedRun:
    """Recorder, simulator and controllers.

    Attributes:
        recorder: The process that writes the bag.
        status: Exit status of the controllers once `finish` has ended them.
        failed: Calls of scripts that failed, or hung, at some time, known then.
        failures: When control laws and conditions failed, known then.
        reloads: When scripts were loaded again.
        trouble: What went wrong with the robots, though no process died; here nothing can.
        is_stuck: Whether robots stay paused, for nobody can start them; here anybody can.
    """

    trouble = ''
    is_stuck = False

    def __init__(self, supervisor: Supervisor, args: argparse.Namespace, bag: Path) -> None:
        """Start the processes."""
        self.status = 0
        self.reloads = ReloadTimes(self.elapsed)
        self.failed: tuple[ScriptCall, ...] = ()
        self.failures: tuple[ScriptFailure, ...] = ()
        self._supervisor = supervisor
        recorder = node_command(RECORDER, RecorderOptions(output=bag).arguments())
        self.recorder = supervisor.start('record', recorder)
        told = SimulationOptions.of(args)
        self._lockstep, self._rtf = told.lockstep, told.rtf
        nb_steps = told.nb_steps(args.duration) if told.lockstep else None
        lockstep = SimulatorOptions(recorded=told.lockstep, nb_steps=nb_steps)
        robots = node_command(SIMULATOR, told.arguments() + lockstep.arguments())
        self._simulator = supervisor.start('simu', robots)
        options = ControllerOptions(
            nb_robots=args.nb_robots,
            model=args.model,
            limits=limits_named(args.limits) if args.limits != NO_LIMITS else None,
            recorded=True,
            simulator=self._simulator.process.pid,
        )
        laws = node_command(CONTROLLER, law_arguments(args, options, FilterOptions.of(args)))
        self._ctrl = supervisor.start('ctrl', laws)
        self._ctrl.on_report = self.reloads.take
        self._ctrl.on_hang = partial(stop_robots_of, supervisor, self._ctrl)

    @property
    def started(self) -> bool:
        """Whether the robots are under control."""
        return self._ctrl.heard(Started) is not None

    @property
    def paused(self) -> bool:
        """Whether somebody has paused the robots."""
        report = (self._simulator if self._lockstep else self._ctrl).heard(Paused)
        return report is not None and report.paused

    def elapsed(self, wall_s: float) -> float:
        """Return how long the run has lasted in its own time, `wall_s` s after its start."""
        reached = self._simulator.heard(Reached)
        return (reached.t if reached else 0.0) if self._lockstep else wall_s * self._rtf

    @property
    def missing(self) -> str:
        """What a run that has not started waits for."""
        if not self._simulator.heard(Ready):
            return 'the simulator is not ready'
        if not self.recorder.heard(Recording):
            return 'the recorder has not found the topics of all robots'
        return self._ctrl.calls.missing

    def tick(self) -> None:
        """Do what is to be done ten times a second: nothing."""

    def finish(self) -> None:
        """Stop the controllers."""
        self._supervisor.stop(self._ctrl)
        robots = self._simulator.calls.failed
        self.status = self._ctrl.exit_status or int(robots != ())
        self.failed = self._ctrl.calls.failed + robots
        self.failures = self._ctrl.calls.failures

    def stop(self) -> None:
        """Stop all, controllers first: their last command, zero, is to be in the bag."""
        self._supervisor.stop(self._ctrl, self.recorder, self._simulator)


class EmulatedRun:
    """Recorder, emulated lab, bridge, pause node and controllers; it presses start itself.

    Attributes:
        started: Whether the robots are under control and not paused.
        paused: Whether they are paused now.
        recorder: The process that writes the bag.
        status: Exit status of the controllers once `finish` has ended them.
        failed: Calls of scripts that failed, or hung, at some time, known then.
        failures: When control laws and conditions failed, known then.
        reloads: When scripts were loaded again.
    """

    def __init__(
        self,
        supervisor: Supervisor,
        args: argparse.Namespace,
        bag: Path,
        lab: Lab,
        pages: Sequence[Child] = (),
    ) -> None:
        """Start the processes; robots that somebody has paused can be started on the pages."""
        self.started = False
        self.paused = True
        self.status = 0
        self.reloads = ReloadTimes(self.elapsed)
        self._paused = ''
        self._changed = 0.0
        self._pages = pages
        self._unready = ''
        self.failed: tuple[ScriptCall, ...] = ()
        self.failures: tuple[ScriptFailure, ...] = ()
        self._supervisor = supervisor
        recorder = node_command(RECORDER, RecorderOptions(output=bag).arguments())
        self.recorder = supervisor.start('record', recorder)
        told = emulated_lab_options(args)
        self._experiment = Experiment(supervisor, lab, args, told, recorded=True)
        self._experiment.on_status = self._start_when_ready
        self._experiment.on_script = self.reloads.take
        for page in pages:
            self._experiment.follow_page(page)

    def _start_when_ready(self, status: Status) -> None:
        ready = all(robot.ready for robot in status.robots)
        if status.paused and self._experiment.controlled and ready and not self.started:
            self._experiment.wish(Word.GO, 'by command')
        self.started = self.started or not status.paused
        if status.paused != self.paused:
            self.paused, self._changed = status.paused, time.monotonic()
        self._unready = '; '.join(
            f'{robot.name} is {robot.reason}' for robot in status.robots if not robot.ready
        )
        if self.started and status.paused and (status.emergency or not self._paused):
            self._paused = f'the robots were paused: {status.why}'

    @property
    def missing(self) -> str:
        """What a run that has not started waits for."""
        if not self._experiment.controlled:
            return self._experiment.missing
        return self._unready or 'nothing is heard of the bridge process'

    @property
    def trouble(self) -> str:
        """Why the robots were paused meanwhile, or which did not stop; empty if all went well."""
        if runaways := ', '.join(sorted(self._experiment.runaways)):
            return f'{runaways} did not stop when commanded zero'
        return self._paused + '; nobody is here to start them again' * self.is_stuck

    @property
    def is_stuck(self) -> bool:
        """Whether robots stay paused, at rest by now: no page is there to start them."""
        at_rest = time.monotonic() - self._changed > _COMES_TO_REST_S
        waits = any(page.running() for page in self._pages)
        return self.started and self.paused and at_rest and not waits

    def elapsed(self, wall_s: float) -> float:
        """Return how long the run has lasted, `wall_s` s after its start."""
        return wall_s

    def tick(self) -> None:
        """Show the pause process that somebody is there; ten times a second."""
        self._experiment.wish(Word.ALIVE)

    def finish(self) -> None:
        """Stop the robots and all that commands them."""
        self.status = self._experiment.stop()
        self.failed = self._experiment.failed
        self.failures = self._experiment.failures

    def stop(self) -> None:
        """Stop all; the last command, zero, is to be in the bag."""
        self._experiment.stop()
        self._supervisor.stop(self.recorder)
        self._experiment.stop_lab()


def outcome_of(failed: Sequence[ScriptCall]) -> Outcome:
    """Return the outcome of a run whose controllers have ended, from the calls that failed."""
    laws: dict[str, list[int]] = {}
    conditions: dict[str, list[int]] = {}
    for call in sorted(failed, key=lambda call: call.robot):
        scripts = conditions if call.function is Function.CONDITION else laws
        robots = scripts.setdefault(call.script, [])
        if call.robot not in robots:
            robots.append(call.robot)
    return Outcome.of_failures(laws, conditions)
