"""A recorded run: the processes of its robots and its recorder, from their start to their end."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from tqdm import tqdm

from launch_scripts.experiment import Experiment
from launch_scripts.processes import (
    CONTROLLER,
    PAGE,
    RECORDER,
    SIMULATOR,
    Child,
    ChildDiedError,
    node_command,
)
from launch_scripts.supervisor import StoppedError, Supervisor
from launch_scripts.terminal import Stream
from setcmas_ctrl.laws.control_options import ControllerOptions
from setcmas_expe.lab.lab_file import LabOptions
from setcmas_expe.pause.console import Action, Status
from setcmas_simu.reports import Paused, Ready, Recording, Started
from setcmas_simu.script_calls import ScriptCall, ScriptFailure
from setcmas_simu.simulation_options import SimulationOptions
from setcmas_tools.run.run_folder import RunFolder
from setcmas_tools.run.run_info import Outcome, RunInfo, RunState
from setcmas_tools.run.scenario import Scenario

STOPPED = 130
"""Exit status after Ctrl-C, as in shells."""

_START_TIMEOUT_S = 60.0  # fifty robots take half of it on a busy machine
_PAGE_TIMEOUT_S = 15.0
_STOPPING_S = 2.0
_ROUNDING_S = 1e-9


class ProgressSupervisor(Supervisor):
    """Supervisor that writes above a progress bar on its stderr."""

    def write(self, line: str, stream: Stream) -> None:
        """Write a line of output."""
        with tqdm.external_write_mode(file=self.stderr):
            super().write(line, stream)


class RecordedRun:
    """A run and its recorder; for each kind of robots, a subclass has the other processes.

    Attributes:
        recorder: Process that writes the bag.
        controllers: Process of the control laws; None before its start.
        rtf: Seconds of the run in a second.
    """

    controllers: Child | None = None

    def __init__(self, supervisor: Supervisor, bag: Path, rtf: float = 1.0) -> None:
        self.rtf = rtf
        self._supervisor = supervisor
        recorder = node_command(RECORDER, ['--output', str(bag), '--rtf', str(rtf)])
        self.recorder = supervisor.start('record', recorder)

    @property
    def failed(self) -> tuple[ScriptCall, ...]:
        """Script calls that failed or hung."""
        return self.controllers.failed if self.controllers else ()

    @property
    def failures(self) -> tuple[ScriptFailure, ...]:
        """Periods in which laws and conditions failed, once their process has ended."""
        return self.controllers.failures if self.controllers else ()


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
        robots = node_command(SIMULATOR, simulation.arguments())
        self._simulator = supervisor.start('simu', robots)
        options = ControllerOptions(
            nb_robots=scenario.nb_robots, model=simulation.model, recorded=True
        )
        laws = scenario.law.arguments(scenario.communication, scenario.safety, options)
        self._laws = node_command(CONTROLLER, laws)

    @property
    def started(self) -> bool:
        """Whether the robots are controlled."""
        return self.controllers is not None and self.controllers.reported(Started) is not None

    @property
    def paused(self) -> bool:
        """Whether the robots are paused."""
        report = self.controllers.reported(Paused) if self.controllers else None
        return report is not None and report.paused

    @property
    def missing(self) -> str:
        """Why the run has not started yet."""
        if not self.controllers:
            return 'the simulator is not ready'
        if not self.recorder.reported(Recording):
            return 'the recorder has not found the topics of all robots'
        return self.controllers.missing

    @property
    def failed(self) -> tuple[ScriptCall, ...]:
        """Script calls that failed or hung, those of robots' models among them."""
        return super().failed + self._simulator.failed

    def tick(self) -> None:
        """Start the controllers once the simulator has announced its robots.

        A simulator that refuses to start, because another has these robots, announces nothing.
        """
        if not self.controllers and self._simulator.reported(Ready):
            self.controllers = self._supervisor.start('ctrl', self._laws)

    def finish(self) -> int:
        """Stop the controllers; return the exit status."""
        assert self.controllers
        self._supervisor.stop(self.controllers)
        return self.controllers.exit_status or int(self.failed != ())

    def stop(self) -> None:
        """Stop all, controllers first: the bag must contain their last command, zero."""
        laws = [self.controllers] if self.controllers else []
        self._supervisor.stop(*laws, self.recorder, self._simulator)


class RecordedExperiment(RecordedRun):
    """Recorder, emulated lab, bridge, pause node and controllers; starts the robots itself.

    Attributes:
        started: Whether the robots are controlled and not paused.
        paused: Whether they are paused.
    """

    def __init__(
        self,
        supervisor: Supervisor,
        scenario: Scenario,
        bag: Path,
        lab_options: LabOptions,
        watch: bool,
        serve_keys: Callable[[Experiment], None],
    ) -> None:
        """Start the processes; `lab_options` give them the same lab.

        `serve_keys` is called several times a second, to pass on what the operator pressed.
        """
        self.started = False
        self.paused = True
        self._why_paused = ''
        self._changed = 0.0
        self._unready = ''
        self._serve_keys = serve_keys
        super().__init__(supervisor, bag)
        self._experiment = Experiment(
            supervisor, scenario, lab_options, self._start_when_ready, recorded=True, watch=watch
        )
        self.controllers = self._experiment.controllers

    def _start_when_ready(self, status: Status) -> None:
        ready = all(robot.ready for robot in status.robots)
        if status.paused and self._experiment.controlled and ready and not self.started:
            self._experiment.request(Action.GO, 'by command')
        self.started = self.started or not status.paused
        if status.paused != self.paused:
            self.paused, self._changed = status.paused, time.monotonic()
        self._unready = '; '.join(
            f'{robot.name} is {robot.reason}' for robot in status.robots if not robot.ready
        )
        if self.started and status.paused and (status.emergency or not self._why_paused):
            self._why_paused = f'the robots were paused: {status.why}'

    @property
    def missing(self) -> str:
        """Why the run has not started yet."""
        if not self._experiment.controlled:
            return self._experiment.controllers.missing
        return self._unready or 'the bridge sends no status'

    @property
    def trouble(self) -> str:
        """Which robots did not stop, or why robots were paused; '' if all went well."""
        if runaways := ', '.join(sorted(self._experiment.runaways)):
            return f'{runaways} did not stop when commanded zero velocity'
        return self._why_paused + '; nothing can start them again' * self.is_stuck

    @property
    def is_stuck(self) -> bool:
        """Whether robots stay paused for good: this command starts them only once."""
        at_rest = time.monotonic() - self._changed > _STOPPING_S
        return self.started and self.paused and at_rest

    def tick(self) -> None:
        """Serve the keys, which also shows the pause node that this command is running."""
        self._serve_keys(self._experiment)

    def finish(self) -> int:
        """Stop the robots and everything that commands them; return the exit status."""
        return self._experiment.stop()

    def stop(self) -> None:
        """Stop all processes; the bag must contain the last command, zero."""
        self._experiment.stop()
        self._supervisor.stop(self.recorder)
        self._experiment.stop_lab()


Robots = RecordedExperiment | SimulatedRun


def run_robots(
    verb: str,
    supervisor: Supervisor,
    start: Callable[[], Robots],
    duration: float,
    folder: RunFolder,
    info: RunInfo,
    views: Sequence[tuple[str, list[str]]],
) -> tuple[int, RunInfo | None]:
    """Run the robots, from start to end of their processes.

    `start` starts those of the robots; `duration` is in s, from the first command.

    Returns:
        The exit status, and `info` with how the run went; None if it has not begun.
    """
    folder.create(info)  # not earlier: Ctrl-C would leave it behind
    pages = [supervisor.start(name, command, needed=False) for name, command in views]
    pages = [page for page in pages if page.name == PAGE]
    run: Robots | None = None
    outcome: Outcome | None = None
    try:
        _wait_for(pages, supervisor)
        run = start()
        status, outcome = _controlled(verb, supervisor, run, duration)
    except StoppedError:
        status = STOPPED
        if run and run.started:
            outcome = Outcome(RunState.STOPPED)
    except ChildDiedError as death:
        status = death.exit_status
        if reason := str(death):
            supervisor.warn(f'setcmas {verb}: {reason}; the others are stopped')
            outcome = Outcome(RunState.DIED, detail=reason)
    finally:
        if run:
            run.recorder.shown = outcome is not None  # else it reports a bag that is then removed
            run.stop()
    if outcome is None:
        return status, None
    failures = list(run.failures) if run else []
    return status, replace(info, outcome=outcome, failures=failures or None)


def _controlled(
    verb: str, supervisor: Supervisor, run: Robots, duration: float
) -> tuple[int, Outcome]:
    """Wait for the start, and for the end; stop the control laws; return status and outcome."""
    deadline = time.monotonic() + _START_TIMEOUT_S
    supervisor.run(lambda: run.started or time.monotonic() > deadline, run.tick)
    if not run.started:
        supervisor.warn(
            f'setcmas {verb}: the robots did not start within {_START_TIMEOUT_S:g} s; '
            f'{run.missing}'
        )
        return 1, Outcome(RunState.NOT_STARTED, detail=run.missing)
    _show_progress(supervisor, duration, run)
    trouble, is_stuck = run.trouble, run.is_stuck
    status = run.finish()
    outcome = Outcome.of_calls((call.script, call.robot) for call in run.failed)
    if is_stuck:
        outcome = replace(outcome, state=RunState.NOT_FINISHED)
    if trouble:
        supervisor.warn(f'setcmas {verb}: {trouble}')
        return 1, replace(outcome, detail=trouble)
    return status, replace(outcome, state=RunState.FAILED) if status else outcome


def _wait_for(pages: Sequence[Child], supervisor: Supervisor) -> None:
    """Wait until pages can show the run from its start, with a time-out."""
    deadline = time.monotonic() + _PAGE_TIMEOUT_S
    supervisor.run(
        lambda: (
            all(page.reported(Ready) or not page.running() for page in pages)
            or time.monotonic() > deadline
        )
    )


def _show_progress(supervisor: Supervisor, duration: float, run: Robots) -> None:
    begin = time.monotonic()

    def elapsed() -> float:
        return (time.monotonic() - begin) * run.rtf

    form = '{desc}: {percentage:3.0f}%|{bar}| {n:.0f}/{total:.0f} s'
    with tqdm(
        total=duration, desc='running', bar_format=form, disable=None, file=supervisor.stderr
    ) as bar:

        def advance() -> None:
            run.tick()
            bar.set_description_str('paused' if run.paused else 'running', refresh=False)
            bar.update(min(duration, elapsed()) - bar.n)

        supervisor.run(
            until=lambda: elapsed() >= duration - _ROUNDING_S or run.is_stuck, on_tick=advance
        )
        bar.update(0 if run.is_stuck else duration - bar.n)
