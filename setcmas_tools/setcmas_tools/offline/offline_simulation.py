"""Runs control laws on simulated robots without ROS: the nodes' own functions, in their order."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl import network
from setcmas_ctrl.communication.communication_options import chosen_communication
from setcmas_ctrl.laws.control_options import Algo
from setcmas_ctrl.laws.drawing import drawn_on
from setcmas_ctrl.laws.references import References, references_of_fleet
from setcmas_ctrl.laws.script_errors import ErrorReports
from setcmas_ctrl.laws.script_output import named_output
from setcmas_ctrl.laws.script_seeds import seed_scripts, seeded_generators
from setcmas_ctrl.si_to_uni_script import ScriptConversion, script_conversions
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.planar_pose import through_quaternion
from setcmas_simu.robots.model import POSE, RobotModel
from setcmas_simu.robots.models_by_name import (
    check_models,
    fleet_model,
    model_names,
    robot_models,
)
from setcmas_simu.script_calls import Function
from setcmas_tools.offline import run_progress
from setcmas_tools.offline.offline_fleet import Commander, FleetLaws, OfflineCommunication
from setcmas_tools.run.fleet_motion import FleetTable
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_folder import inputs_of, kept_record
from setcmas_tools.run.run_info import Outcome, RunInfo
from setcmas_tools.run.run_records import Commands, DrawingRecord, commands
from setcmas_tools.run.scenario import Scenario, name_of

_SAME_TIME_S = 1e-9


def simulate(
    scenario: Scenario | Algo,
    nb_robots: int | None = None,
    duration: float | None = None,
    *,
    warn: Callable[[str], None] = print,
    progress: Callable[[float], object] | None = None,
    **changes: Any,
) -> Run:
    """Run control laws on simulated robots, hundreds of times faster than real time.

        from setcmas_tools import Scenario, simulate

        run = simulate('consensus', nb_robots=8, duration=40, loss=0.3)
        run = simulate(Scenario.load('square.yaml'), set={'K': 2})
        run.poses[-1]                    # where the robots end: rows x, y, theta
        plt.plot(run.t, run.poses[:, 0]) # x of every robot over time

    As over ROS, robots have a new state at each multiple of 1/robot_rate, from the last command
    before it; the laws are called at t = 0, 1/rate, 2/rate, ... with the states of that
    time or, between two, with the older ones. Headings go through a quaternion, as messages
    carry them, and are in (-pi, pi]. On one kind of processor equal arguments give equal results.

    Args:
        scenario: A scenario, or a control law: a built-in ('consensus'), a script ('my_law.py'),
            or a function control(robotNo, nbRobots, poses, t) of your own. A script is loaded
            afresh for each robot; a function is shared by all robots, and so is any state that it
            keeps. For a law of each robot: '1:leader.py,2-8:follower.py', or a dictionary
            {1: leader, ...}.
        nb_robots: Number of robots.
        duration: Length of the run in s.
        warn: Shows messages about a failing law, whose robot is commanded zero then, and about
            robots that block each other.
        progress: Called now and then with the time that the run has reached, in s.
        changes: Other values of the scenario by name, as for `Scenario.of`; docs/scenarios.md
            has all.

    Raises:
        SetcmasError: A script cannot be loaded, or an argument is invalid.
    """
    sizes = {'nb_robots': nb_robots, 'duration': duration}
    changes |= {name: value for name, value in sizes.items() if value is not None}
    return Simulation(Scenario.of(scenario, **changes), warn, progress).run()


MAX_STATES = 10_000_000
"""The most states of robots in a run, a state a robot and step; they are held in memory."""

_BYTES_A_STATE = 500  # measured: 150 to 220, and once more while the run changes processes


def checked_steps(scenario: Scenario) -> int:
    """Return the number of steps of the robots, or raise SetcmasError."""
    nb_steps = scenario.robots.nb_steps(scenario.time.duration)
    nb_states = nb_steps * scenario.nb_robots
    if nb_states > MAX_STATES:
        raise SetcmasError(
            f'the run would store {nb_states:.3g} states of robots (about '
            f'{nb_states * _BYTES_A_STATE / 1e9:.3g} GB); the limit is {MAX_STATES:.3g}: use a '
            'shorter duration, fewer robots, or a lower robot rate'
        )
    return nb_steps


class Simulation:
    """A scenario that can be simulated, once."""

    _radio: OfflineCommunication
    _robots: list[RobotModel]
    _fleet: FleetLaws
    _conversions: list[ScriptConversion]
    _references: References | None

    def __init__(
        self,
        scenario: Scenario,
        warn: Callable[[str], None] = print,
        progress: Callable[[float], object] | None = None,
    ) -> None:
        """Raise SetcmasError unless the scenario can be simulated, before a script is loaded.

        `warn` shows messages; `progress` is called with the time that the run has reached, in s.
        """
        self._warn, self._progress = warn, progress
        self._nb_robots = nb_robots = scenario.nb_robots
        self._nb_steps = checked_steps(scenario)
        self._start = scenario.start_poses()
        # Files are found before a script is loaded: it may change the current folder.
        self._scenario = found = scenario.found()
        self._inputs = inputs_of(found)
        self._communication = chosen_communication(nb_robots, found.communication, found.seed)
        self._models = model_names(found.robots.model, nb_robots)
        check_models(self._models, found.robots.limits)
        self._conversion_reports = ErrorReports(warn, function=Function.SI_TO_UNI)
        self._drawings = DrawingRecord()

    def run(self) -> Run:
        """Load the scripts, and simulate; return the run, or raise SetcmasError."""
        seed_scripts(self._scenario.seed)
        with (
            run_progress.of_run(),
            seeded_generators(),
            named_output(),
            drawn_on(self._drawings),
        ):
            self._radio = OfflineCommunication(self._communication, self._nb_robots, self._warn)
            with network.exchanged_by(self._radio):
                self._load()
                return self._integrate()

    def _load(self) -> None:
        """Load the scripts of robots, laws and conversions."""
        scenario, nb_robots = self._scenario, self._nb_robots
        robots, call = range(1, nb_robots + 1), run_progress.current.call
        self._robots = robot_models(
            self._models,
            robots,
            scenario.robots.limits,
            self._warn,
            partial(call.begin, function=Function.STEP),
        )
        self._fleet = FleetLaws(scenario.law, nb_robots, self._warn)
        self._conversions = script_conversions(
            scenario.law.si_to_uni,
            robots,
            self._conversion_reports,
            lambda: self._radio.t,
            _noted_call,
        )
        scripts = [(one.names, one.path) for one in self._fleet.laws]
        self._references = references_of_fleet(scripts, nb_robots, self._warn)

    def _integrate(self) -> Run:
        """Simulate the robots; return the run."""
        scenario, radio, nb_robots = self._scenario, self._radio, self._nb_robots
        robot_rate, nb_steps = scenario.robots.robot_rate, self._nb_steps
        commander = Commander(
            scenario.law, scenario.safety, nb_robots, self._warn, self._conversions
        )
        commander.use(self._robots)
        model = fleet_model(self._robots)
        state = model.start(np.array(self._start, dtype=float))
        held = np.zeros((3, nb_robots))  # the commands, until the next ones
        t = np.arange(nb_steps + 1) / robot_rate
        control_t, due = _calls(t, 1 / robot_rate, scenario.law.rate)
        velocities = np.empty((len(control_t), 5 if scenario.safety.is_on else 2, nb_robots))
        notes = run_progress.current
        states = notes.new_states(nb_steps + 1, nb_robots)
        states[0] = state[:6]
        notes.done = 1
        poses = through_quaternion(state[POSE])
        if radio.is_on:
            radio.measure(poses, state[3], 0.0)

        def advance(done: int, step: int) -> Floats:
            """Move the robots to a later step; return their poses as their messages have them."""
            nonlocal state
            new = states[done + 1 : step + 1]
            for row in new:
                state = model.step(state, held, 1 / robot_rate)
                row[:] = state[:6]
            notes.call.end()
            notes.done = step + 1
            if self._progress:
                self._progress(float(t[step]))
            if not radio.is_on:
                return through_quaternion(state[POSE])
            received = through_quaternion(new[:, :3].transpose(1, 0, 2))
            for k, now in enumerate(t[done + 1 : step + 1].tolist()):
                radio.measure(received[:, k], new[k, 3], now)
            return received[:, -1]

        done = 0
        for call, (now, step) in enumerate(zip(control_t.tolist(), due, strict=True)):
            if step > done:
                poses, done = advance(done, step), step
            self._drawings.t = now
            known_poses, adjacency = radio.known_poses(poses, now)
            commanded = commander(self._fleet(known_poses, now, adjacency), poses)
            velocities[call, :2] = commanded.wanted
            if commanded.allowed is not None:
                velocities[call, 2:] = commanded.allowed
            held = commanded.commands
        advance(done, nb_steps)
        return Run(
            motion(t, states[:, :3], states[:, 3], states[:, 5]),
            _commands(control_t, velocities),
            radio.record(t),
            self._drawings.drawings(),
            self._references,
            messages=radio.sent,
            info=self._info(),
            inputs=tuple(self._inputs),
        )

    def _info(self) -> RunInfo:
        """Return the outcome of the run, with the failures of its scripts."""
        laws, conversions = self._fleet.reports, self._conversion_reports
        conditions = self._radio.reports
        condition = Path(name_of(self._scenario.communication.ctc) or 'by default').name
        failed_models = [robot for robot, one in enumerate(self._robots, 1) if one.failed]
        failed = [
            *((self._fleet.laws[robot - 1].path.name, robot) for robot in laws.failed_robots),
            *((self._conversions[i - 1].path.name, i) for i in conversions.failed_robots),
            *((condition, robot) for robot in conditions.failed_robots),
            *((Path(self._models[robot - 1]).name, robot) for robot in failed_models),
        ]
        failures = [*laws.failures, *conversions.failures, *conditions.failures]
        failures.sort(key=attrgetter('t'))
        record = kept_record(self._scenario, self._inputs)
        outcome = Outcome.of_calls(failed)
        return RunInfo(outcome=outcome, scenario=record, failures=failures or None)


@contextmanager
def _noted_call(robot: int, path: Path) -> Iterator[None]:
    """Note a call of an own conversion as the current one."""
    call = run_progress.current.call
    call.begin(robot, path, Function.SI_TO_UNI)
    try:
        yield
    finally:
        call.end()


def _calls(t: Floats, Ts: float, rate: float) -> tuple[Floats, list[int]]:
    """Return the times at which laws are called, in s, and the robots' step that each precedes.

    The robots' states are at times t, Ts s apart; the calls come at a rate in Hz.
    """
    before = t[:-1] + Ts - _SAME_TIME_S  # calls before these times precede the robots' steps
    times = np.arange(math.ceil(before[-1] * rate) + 1) / rate
    times = times[times < before[-1]]
    return times, np.searchsorted(before, times, side='right').tolist()


def motion(t: Floats, poses: Floats, V: Floats, omega: Floats) -> FleetTable:
    """Return the table of a fleet's states: poses (K, 3, N) in m and rad, as simulated.

    Forward speeds V in m/s and turn rates in rad/s, shape (K, N), are those over the step that led
    to each state.
    """
    times, robots = _rows(t, poses.shape[2])
    x, y, theta = through_quaternion(poses.transpose(1, 0, 2).reshape(3, -1))
    return FleetTable(times, robots, x, y, theta, V.ravel(), omega.ravel())


def _commands(t: Floats, velocities: Floats) -> Commands:
    """Return the commands of a fleet.

    Velocities (C, 2, N) in m/s are those wanted, after saturation; with a filter, (C, 5, N), also
    the allowed ones and its verdicts.
    """
    times, robots = _rows(t, velocities.shape[2])
    return commands(times, robots, *velocities.transpose(1, 0, 2).reshape(velocities.shape[1], -1))


def _rows(t: Floats, nb_robots: int) -> tuple[Floats, NDArray[np.int64]]:
    robots = np.arange(1, nb_robots + 1, dtype=np.int64)
    return np.repeat(t, nb_robots), np.tile(robots, len(t))


@contextmanager
def silent() -> Iterator[None]:
    """Discard what scripts print."""
    with Path(os.devnull).open('w') as nowhere, redirect_stdout(nowhere), redirect_stderr(nowhere):
        yield
