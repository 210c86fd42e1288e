"""Runs in the emulated lab, for `setcmas run --emulate` and for rubrics."""

from __future__ import annotations

import math
import subprocess
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from launch_scripts.processes.environment import require_ros
from launch_scripts.processes.experiment import Experiment
from launch_scripts.processes.node_commands import node_command
from launch_scripts.processes.run_processes import RecordedRun
from launch_scripts.processes.supervisor import Supervisor
from launch_scripts.terminal.terminal_output import warner
from setcmas_ctrl.filter.barrier_constraints import check_starts
from setcmas_expe.emulation.emulation_options import (
    EmulationOptions,
    check_emulated_mocap,
    emulated_start_poses,
)
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_file import DEFAULT_FILE
from setcmas_expe.lab.lab_options import LabOptions
from setcmas_expe.pause.console import Action, Status
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.model import ROBOT_LIMITS
from setcmas_simu.robots.models import NO_LIMITS
from setcmas_tools.grade.marks import Failure, LawRunner, ScenarioRun
from setcmas_tools.grade.rubric import Rubric
from setcmas_tools.grade.rubric_scenarios import CONTROL, MarkedScenario
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import RunInfo, State
from setcmas_tools.scenario.scenario import Scenario

_STOPPING_S = 2.0


def lab_options(scenario: Scenario, **others: Any) -> LabOptions:
    """Return the lab's options for the processes; robots without limits have the lab's.

    Args:
        scenario: The experiment.
        others: Options that scenarios do not have.
    """
    values = scenario.values()
    if values['limits'] == NO_LIMITS:
        values['limits'] = None
    return LabOptions.among({**values, **others})


def bounded_lab_options(
    scenario: Scenario, typed: Mapping[str, Any], from_file: bool, **others: Any
) -> LabOptions:
    """Return the options of a lab; a scenario file may tighten the others, never loosen them.

    Args:
        scenario: The experiment.
        typed: Values on the command line, by name; they override the lab file.
        from_file: Whether the scenario is from a file.
        others: As for `lab_options`.

    Raises:
        SetcmasError: The scenario loosens something.
    """
    options = lab_options(scenario, **others)
    if not from_file:
        return options
    which = {'algo': '', 'lab': scenario.lab.lab, 'nb_robots': scenario.robots.nb_robots}
    bounds = lab_options(Scenario.of(**{**which, **typed}), **others).chosen()
    own = scenario.safety.obstacles
    if own and 'obstacles' not in typed:
        both = dict.fromkeys(filter(None, (str(bounds.obstacles), own)))
        options = replace(options, obstacles='; '.join(both))
    options.chosen().check_tightens(bounds)
    return options


def check_emulated(scenario: Scenario, lab: Lab) -> None:
    """Check that a lab can be emulated with the robots of a scenario.

    Raises:
        SetcmasError: It cannot, or robots would start too close to each other.
    """
    EmulationOptions.among(scenario.values()).robot_model([one.number for one in lab.robots])
    check_emulated_mocap(lab.mocap)
    poses = emulated_start_poses(lab.arena, lab.nb_robots, scenario.robots)
    check_starts(lab.safety(scenario.safety), poses)


def in_lab(scenario: Scenario, lab: Lab) -> Scenario:
    """Return a scenario with the values of its emulated lab."""
    known = (name for name, limits in ROBOT_LIMITS.items() if limits == lab.limits)
    return scenario.replace(
        lab=scenario.lab.lab or DEFAULT_FILE,
        poses=emulated_start_poses(lab.arena, scenario.nb_robots, scenario.robots),
        pose=(),
        random_poses=None,
        limits=NO_LIMITS if scenario.robots.model else next(known, NO_LIMITS),
        filter=lab.filter,
        arena=lab.arena,
        min_separation=lab.min_separation,
        obstacles=str(lab.obstacles) or None,
        accel=lab.accel if lab.accel < math.inf else None,
    )


def decided(lab: Lab) -> dict[str, Any]:
    """Return the values that run.yaml records for a lab, in place of the scenario's."""
    return {'limits': asdict(lab.limits), 'robot_rate': None}


class EmulatedRun(RecordedRun):
    """Recorder, emulated lab, bridge, pause node and controllers; starts the robots itself.

    Attributes:
        started: Whether the robots are controlled and not paused.
        paused: Whether they are paused.
    """

    def __init__(self, supervisor: Supervisor, scenario: Scenario, bag: Path, lab: Lab) -> None:
        self.started = False
        self.paused = True
        self._why_paused = ''
        self._changed = 0.0
        self._unready = ''
        super().__init__(supervisor, bag)
        self._experiment = Experiment(
            supervisor, lab, scenario, lab_options(scenario), recorded=True
        )
        self._experiment.on_status = self._start_when_ready

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
            return self._experiment.missing
        return self._unready or 'the bridge sends no status'

    @property
    def trouble(self) -> str:
        """Which robots did not stop, or why robots were paused; '' if all went well."""
        if runaways := ', '.join(sorted(self._experiment.runaways)):
            return f'{runaways} did not stop when commanded zero'
        return self._why_paused + '; nothing can start them again' * self.is_stuck

    @property
    def is_stuck(self) -> bool:
        """Whether robots stay paused for good: this command starts them only once."""
        at_rest = time.monotonic() - self._changed > _STOPPING_S
        return self.started and self.paused and at_rest

    def tick(self) -> None:
        """Show the pause node that this command is running."""
        self._experiment.request(Action.ALIVE)

    def finish(self) -> None:
        """Stop the robots and everything that commands them."""
        self.status = self._experiment.stop()
        self.failed = self._experiment.failed
        self.failures = self._experiment.failures

    def stop(self) -> None:
        """Stop all processes; the bag must contain the last command, zero."""
        self._experiment.stop()
        self._supervisor.stop(self.recorder)
        self._experiment.stop_lab()


_RUN = ('run', '--emulate', '--no-plots')
_INVALID_INPUT = 2
_TO_THE_END = (State.COMPLETE, State.FAILED)

Show = Callable[[str], None]


def runners_in_lab(rubric: Rubric, verb: str) -> Callable[[Path], LawRunner]:
    """Run a rubric's solution in the emulated lab; return the function that runs a script there.

    Args:
        rubric: Its scenarios are run.
        verb: Name of the command for progress messages.

    Raises:
        SetcmasError: ROS is missing, or the solution does not complete a run.
    """
    require_ros('without --emulate you need no ROS; ')
    show = warner(verb)
    _run_solution(rubric, show)
    return lambda script: partial(_run_marked, script, rubric, show)


def _run_solution(rubric: Rubric, show: Show) -> None:
    """Run the model solution in all scenarios, for the reference paths."""
    if rubric.references or (rubric.solution is None and rubric.function == CONTROL):
        return
    for scenario in rubric.scenarios:
        done = _run_marked(rubric.solution, rubric, show, scenario)
        if not done.run or done.failure:
            reason = done.failure.message if done.failure else 'it did not start'
            raise SetcmasError(
                f"the solution fails in scenario '{scenario.name}' of {rubric.file}: {reason}"
            )
        rubric.keep_solution(scenario, done.run)


def _run_marked(
    script: Path | None, rubric: Rubric, show: Show, scenario: MarkedScenario
) -> ScenarioRun:
    """Run a scenario in the emulated lab, without sandbox; no script is the default condition."""
    name = script.name if script else 'the solution'
    show(f'{name}, {scenario.name}: {scenario.seconds:g} s in the emulated lab')
    chosen = scenario.of(str(script) if script else None, rubric.function)
    done = _run_in_lab(chosen, script)
    if done.failure and done.run and done.run.outcome.state is State.COMPLETE:
        # Not the script, but something else stopped the robots, such as an overloaded machine.
        show(f'{done.failure.message}; trying once more')
        done = _run_in_lab(chosen, script)
    return done


def _run_in_lab(scenario: Scenario, script: Path | None) -> ScenarioRun:
    with TemporaryDirectory(prefix='setcmas_') as folder:
        place = Path(folder, 'run')
        options = [*_RUN, '--output', str(place), *passed_on(scenario)]
        command = node_command('launch_scripts.cli', options)
        done = subprocess.run(command, capture_output=True, text=True, errors='replace')
        if done.returncode == _INVALID_INPUT or not (place / 'csv').is_dir():
            return _not_run(done.stderr, script)
        run = replace(Run.load(place, lambda _: None), bag=None)  # it goes with the folder
    return ScenarioRun(run, _failure(run.info), run.outcome.state in _TO_THE_END)


def _failure(info: RunInfo) -> Failure | None:
    """Return the first error of a script and how the run ended; None if all went well."""
    outcome = info.outcome
    if outcome.state is State.COMPLETE and not outcome.detail:
        return None
    if not info.failures:
        return Failure(str(outcome))
    first = info.failures[0]
    who = f'robot {first.robot} at t = {first.t:.1f} s'
    return Failure(f'{who}: {first.text}\n{outcome}')


def _not_run(messages: str, script: Path | None) -> ScenarioRun:
    """Return a result without run if the script is the cause.

    Raises:
        SetcmasError: The script is not the cause.
    """
    shown = [line for line in messages.splitlines() if line.strip()] or ['it did not start']
    message = shown[-1].removeprefix('setcmas run: ')
    if script is None or script.name not in messages:
        raise SetcmasError(f'the emulated lab: {message}')
    return ScenarioRun(None, Failure(message), is_complete=False)


def passed_on(scenario: Scenario) -> list[str]:
    """Return the arguments of `setcmas run` for a scenario; it starts where it does offline."""
    robots = scenario.robots
    if robots.poses or robots.pose or robots.random_poses:
        poses = dict(enumerate(robots.start_poses(scenario.nb_robots).T.tolist(), 1))
        scenario = scenario.replace(poses=poses, pose=(), random_poses=None)
    parts = (scenario.communication, scenario.safety, scenario.robots, scenario.time)
    return scenario.law.arguments(*parts)
