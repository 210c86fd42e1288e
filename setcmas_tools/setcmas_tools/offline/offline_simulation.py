"""Runs control laws on simulated robots without ROS: the nodes' own functions, in their order."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.laws.control_options import Algo
from setcmas_ctrl.laws.script_output import named_output
from setcmas_ctrl.laws.script_seeds import seed_scripts, seeded_generators
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.planar_pose import through_quaternion
from setcmas_simu.robots.model import POSE
from setcmas_simu.robots.models_by_name import fleet_model
from setcmas_tools.offline import run_progress
from setcmas_tools.offline.loaded_scenario import (
    FleetLaws,
    Simulation,
    commands,
    motion,
)
from setcmas_tools.offline.offline_commands import Commander
from setcmas_tools.offline.offline_communication import OfflineCommunication
from setcmas_tools.run.law_output import DrawingRecord, recorded_drawings
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_tables import RunTables
from setcmas_tools.run.scenario import Scenario

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
    if isinstance(scenario, Scenario):
        scenario = scenario.replace(**changes)
    else:
        scenario = Scenario.of(scenario, **changes)
    one = Simulation(scenario, warn, progress)
    seed_scripts(one.seed)
    radio = OfflineCommunication(one.communication, one.nb_robots, warn)
    with (
        run_progress.of_run(),
        seeded_generators(),
        named_output(),
        network.exchanged_by(radio),
        recorded_drawings() as drawings,
    ):
        one.load(lambda: radio.t)
        return _run(one, radio, drawings)


def _run(one: Simulation, radio: OfflineCommunication, drawings: DrawingRecord) -> Run:
    """Simulate a run whose scripts are loaded."""
    robots = range(1, one.nb_robots + 1)
    law, safety = one.scenario.law, one.scenario.safety
    commander = Commander(law, safety, robots, one.nb_robots, one.warn, one.conversions)
    commander.use(one.models)
    controllers = FleetLaws(one.laws, commander, one.warn)
    t, states, control_t, velocities = _integrate(controllers, radio, one, drawings)
    tables = RunTables(
        motion(t, states[:, :3], states[:, 3], states[:, 5]),
        commands(control_t, velocities),
        radio.record(t),
        drawings.drawings(),
        messages=radio.sent,
    )
    conditions = radio.reports if radio.is_on else None
    return one.run(tables, controllers.reports, conditions)


def _integrate(
    controllers: FleetLaws,
    radio: OfflineCommunication,
    given: Simulation,
    drawings: DrawingRecord,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Simulate the robots; return times and states, and the arguments of `commands`."""
    nb_steps, progress, scenario = given.nb_steps, given.progress, given.scenario
    robot_rate = scenario.robots.robot_rate
    nb_robots = given.nb_robots
    model = fleet_model(given.models)
    state = model.start(np.array(given.start, dtype=float))
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
        if progress:
            progress(float(t[step]))
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
        drawings.t = now
        commanded = controllers(poses, now, *radio.known_poses(poses, now))
        velocities[call, :2] = commanded.wanted
        if commanded.allowed is not None:
            velocities[call, 2:] = commanded.allowed
        held = commanded.commands
    advance(done, nb_steps)
    return t, states, control_t, velocities


def _calls(t: Floats, Ts: float, rate: float) -> tuple[Floats, list[int]]:
    """Return the times at which laws are called, in s, and the robots' step that each precedes.

    The robots' states are at times t, Ts s apart; the calls come at a rate in Hz.
    """
    before = t[:-1] + Ts - _SAME_TIME_S  # calls before these times precede the robots' steps
    times = np.arange(math.ceil(before[-1] * rate) + 1) / rate
    times = times[times < before[-1]]
    return times, np.searchsorted(before, times, side='right').tolist()


@contextmanager
def silent() -> Iterator[None]:
    """Discard what scripts print."""
    with Path(os.devnull).open('w') as nowhere, redirect_stdout(nowhere), redirect_stderr(nowhere):
        yield
