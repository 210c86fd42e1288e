"""The processes of `setcmas run`: a recorder, robots, and their controllers."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from launch_scripts.processes.child_process import ChildReport
from launch_scripts.processes.node_commands import (
    CONTROLLER,
    RECORDER,
    SIMULATOR,
    node_command,
    stop_robots_of,
)
from launch_scripts.processes.supervisor import Supervisor
from setcmas_ctrl.control.control_options import ControllerOptions
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_simu.reports.reports import Paused, Reached, Ready, Recording, Reloaded, Started
from setcmas_simu.reports.script_calls import Function, ScriptCall, ScriptFailure
from setcmas_simu.robots.model import limits_named
from setcmas_simu.robots.models import NO_LIMITS
from setcmas_simu.simulator.simulator_options import SimulationOptions, SimulatorOptions
from setcmas_tools.bags.recording_options import RecorderOptions
from setcmas_tools.run.run_info import Outcome
from setcmas_tools.scenario.scenario import Scenario


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


class RecordedRun:
    """A run and its recorder; the other processes are those of a kind of run.

    Attributes:
        recorder: The process that writes the bag.
        status: Exit status of the controllers once `finish` has ended them.
        failed: Calls of scripts that failed, or hung, at some time, known then.
        failures: When control laws and conditions failed, known then.
        reloads: When scripts were loaded again.
    """

    def __init__(self, supervisor: Supervisor, bag: Path) -> None:
        """Start the recorder."""
        self.status = 0
        self.reloads = ReloadTimes(self.elapsed)
        self.failed: tuple[ScriptCall, ...] = ()
        self.failures: tuple[ScriptFailure, ...] = ()
        self._supervisor = supervisor
        recorder = node_command(RECORDER, RecorderOptions(output=bag).arguments())
        self.recorder = supervisor.start('record', recorder)

    def elapsed(self, wall_s: float) -> float:
        """Return how long the run has lasted in its own time, `wall_s` s after its start."""
        return wall_s


class SimulatedRun(RecordedRun):
    """Recorder, simulator and controllers.

    Attributes:
        trouble: What went wrong with the robots, though no process died; here nothing can.
        is_stuck: Whether robots stay paused, for nobody can start them; here anybody can.
    """

    trouble = ''
    is_stuck = False

    def __init__(self, supervisor: Supervisor, scenario: Scenario, bag: Path, watch: bool) -> None:
        """Start the processes; `watch` is whether scripts are loaded again when saved."""
        super().__init__(supervisor, bag)
        told = SimulationOptions.among(scenario.values())
        self._lockstep, self._rtf = told.lockstep, told.rtf
        nb_steps = told.nb_steps(scenario.time.duration) if told.lockstep else None
        lockstep = SimulatorOptions(recorded=told.lockstep, nb_steps=nb_steps)
        robots = node_command(SIMULATOR, told.arguments() + lockstep.arguments())
        self._simulator = supervisor.start('simu', robots)
        options = ControllerOptions(
            nb_robots=scenario.nb_robots,
            model=told.model,
            limits=limits_named(told.limits) if told.limits != NO_LIMITS else None,
            watch=watch,
            recorded=True,
            simulator=self._simulator.process.pid,
        )
        laws = node_command(CONTROLLER, controller_arguments(scenario, options, scenario.safety))
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


def controller_arguments(
    scenario: Scenario, options: ControllerOptions, safety: FilterOptions
) -> list[str]:
    """Return the command line of a controller process.

    Args:
        scenario: Has the control law and the communication.
        options: What concerns the process.
        safety: What keeps robots apart.
    """
    parts = (scenario.law, scenario.communication, safety, options)
    return [argument for part in parts for argument in part.arguments()]


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
