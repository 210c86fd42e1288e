"""Runs control laws on simulated robots without ROS: the nodes' own functions, in their order."""

from __future__ import annotations

import builtins
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from setcmas_ctrl.communication.graph import COMPLETE
from setcmas_ctrl.communication.options import CommunicationOptions, Condition, Graph
from setcmas_ctrl.communication.settings import chosen_communication
from setcmas_ctrl.control.options import RATE_HZ as CONTROL_RATE_HZ
from setcmas_ctrl.control.options import GainOptions
from setcmas_ctrl.control.saturation import VNOM
from setcmas_ctrl.scripts.output import named_output
from setcmas_ctrl.scripts.random_seed import SEED, seed_scripts
from setcmas_ctrl.scripts.settings import Settings
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import start_poses
from setcmas_simu.robots.mixed_fleet import fleet_model
from setcmas_simu.robots.models import NO_LIMITS, check_models, model_names, robot_models
from setcmas_simu.robots.si_to_uni import KOMEGA
from setcmas_simu.robots.unicycle import RATE_HZ as ROBOT_RATE_HZ
from setcmas_simu.robots.virtual_fleet import VirtualFleet
from setcmas_simu.simulator.options import SimulationOptions
from setcmas_tools.offline.communication import OfflineCommunication
from setcmas_tools.offline.fleet_laws import FleetLaws, load_laws
from setcmas_tools.records.communication import CommunicationRecord
from setcmas_tools.records.fleet_table import FleetTable
from setcmas_tools.run.options import RunOptions

Floats = NDArray[np.float64]
_SAME_TIME_S = 1e-9


@dataclass(frozen=True, repr=False)
class OfflineRun:
    """What happened in an offline run of N robots over K steps.

    Attributes:
        t: Times of the robots' states in s, shape (K + 1,).
        poses: Rows x, y in m and theta in rad, shape (K + 1, 3, N).
        V: Forward speeds over the step that led to each state in m/s, shape (K + 1, N).
        omega: Turn rates over that step in rad/s, shape (K + 1, N).
        control_t: Times at which the control laws were called in s, shape (C,).
        velocities: What they asked for, after saturation: rows vx, vy in m/s, shape (C, 2, N).
        call_time: Mean duration of a call of each robot's law in s, shape (N,).
        failed_laws: The robots whose law failed at some time, sorted.
        failed_conditions: The robots whose triggering condition failed at some time, sorted.
        communication: What went over the links; None if all robots knew all poses at all times.
        table: The same as `t`, `poses`, `V` and `omega` in the form of fleet.csv.
    """

    t: Floats
    poses: Floats
    V: Floats
    omega: Floats
    control_t: Floats
    velocities: Floats
    call_time: Floats
    failed_laws: list[int]
    failed_conditions: list[int]
    communication: CommunicationRecord | None = None

    def __repr__(self) -> str:
        """Return one line: arrays would flood a notebook."""
        nb_steps, _, nb_robots = self.poses.shape
        return f'OfflineRun({nb_robots} robots, {nb_steps - 1} steps, {self.t[-1]:g} s)'

    @property
    def failed_robots(self) -> list[int]:
        """The robots whose law or triggering condition failed at some time, sorted."""
        return sorted({*self.failed_laws, *self.failed_conditions})

    @property
    def table(self) -> FleetTable:
        """A row for each robot at each time: t, robot, x, y, theta, v, omega."""
        nb_times, _, nb_robots = self.poses.shape
        x, y, theta = self.poses.transpose(1, 0, 2).reshape(3, -1)
        return FleetTable(
            np.repeat(self.t, nb_robots),
            np.tile(np.arange(1, nb_robots + 1), nb_times),
            x,
            y,
            theta,
            self.V.ravel(),
            self.omega.ravel(),
        )


def simulate(
    algo: str | Path | Callable[..., Any],
    nb_robots: int = 1,
    duration: float = 40.0,
    *,
    poses: ArrayLike | None = None,
    model: str | None = None,
    limits: str = NO_LIMITS,
    vnom: float = VNOM,
    komega: float = KOMEGA,
    rate: float = CONTROL_RATE_HZ,
    robot_rate: float = ROBOT_RATE_HZ,
    seed: int = SEED,
    settings: Settings | None = None,
    graph: Graph = COMPLETE,
    range: float | None = None,  # noqa: A002 (as on the command line)
    event_triggered: bool = False,
    ctc: Condition = None,
    delay: float = 0.0,
    loss: float = 0.0,
    noise: float = 0.0,
    warn: Callable[[str], None] = print,
    progress: Callable[[float], object] | None = None,
) -> OfflineRun:
    """Run a control law on simulated robots, thousands of times faster than real time.

        from setcmas_tools import simulate

        run = simulate('consensus', nb_robots=8, duration=40)
        run.poses[-1]                    # where the robots end: rows x, y, theta
        plt.plot(run.t, run.poses[:, 0]) # x of every robot over time

    As over ROS, robots have a new state at each multiple of 1/robot_rate, which the last command
    before it has led to; the laws are called at t = 0, 1/rate, 2/rate, ... with the states of that
    moment or, between two, with the older ones. Equal arguments give equal results.

    Args:
        algo: A built-in ('consensus'), a script ('my_law.py'), or a function
            control(robotNo, nbRobots, poses, t) of your own. A script is loaded afresh for each
            robot; a function is shared by all robots, and so is any state that it keeps.
        nb_robots: Number of robots.
        duration: Length of the run in s.
        poses: Start poses: rows x, y in m and theta in rad, shape (3, nb_robots); by default
            those of `setcmas simu`.
        model: How the robots move: a model ('burger'), a script ('my_robot.py'), or for some of
            them '1:burger,2-4:my_robot.py'; the others are unicycles.
        limits: What unicycles can do: 'ideal', 'burger' or 'waffle'.
        vnom: Largest speed that is asked of a robot in m/s.
        komega: Gain on the heading error in 1/s.
        rate: Rate of control in Hz.
        robot_rate: Rate of the robots' steps in Hz.
        settings: Values for module-level names of the script, such as {'K': 1.2}; what the
            script derives from them follows.
        seed: Seed of the random numbers that scripts and links draw.
        graph: Who hears whom: 'complete', 'ring', 'path', 'star', 'directed_ring', a YAML file,
            or an adjacency matrix (row i: whom robot i hears, and with which weight).
        range: Distance in m up to which robots hear each other; None is no limit.
        event_triggered: Whether robots send their state only when a condition triggers.
        ctc: The condition: a script, or a function ctc(pos, last_pos, t); by default more than
            0.25 m away from the position sent last.
        delay: By how much later messages arrive, in s.
        loss: Probability that a message is lost.
        noise: Standard deviation of received positions in m.
        warn: Shows messages about a failing law; its robot is commanded zero then.
        progress: Called now and then with the time that the run has reached, in s.

    Raises:
        SetcmasError: The script cannot be loaded, or an argument makes no sense.
    """
    RunOptions(duration=duration)
    SimulationOptions(nb_robots=nb_robots, model=model, limits=limits, robot_rate=robot_rate)
    gains = GainOptions(vnom=vnom, komega=komega, rate=rate, seed=seed)
    start = start_poses(nb_robots) if poses is None else np.array(poses, dtype=float)
    if start.shape != (3, nb_robots) or not np.isfinite(start).all():
        raise SetcmasError(
            f'poses have shape {start.shape}; they must be finite numbers of shape '
            f'(3, {nb_robots})'
        )
    options = CommunicationOptions(
        graph=graph,
        range=range,
        event_triggered=event_triggered,
        ctc=ctc,
        delay=delay,
        loss=loss,
        noise=noise,
    )
    tells = chosen_communication(nb_robots, options, seed)
    seed_scripts(seed)
    radio = None if tells.is_ideal else OfflineCommunication(tells, nb_robots, warn)
    names = model_names(model, nb_robots)
    check_models(names, limits)
    nb_steps = max(1, round(duration * robot_rate))
    with named_output():
        robots = fleet_model(robot_models(names, builtins.range(1, nb_robots + 1), limits, warn))
        fleet = VirtualFleet(start, robots)
        laws = load_laws(algo, nb_robots, settings)
        controllers = FleetLaws(laws, robots, gains, warn)
        return _run(fleet, controllers, radio, nb_steps, 1 / robot_rate, rate, progress)


def _run(
    fleet: VirtualFleet,
    controllers: FleetLaws,
    radio: OfflineCommunication | None,
    nb_steps: int,
    Ts: float,
    rate: float,
    progress: Callable[[float], object] | None,
) -> OfflineRun:
    nb_robots = fleet.poses.shape[1]
    t = np.linspace(0.0, nb_steps * Ts, nb_steps + 1)
    states = np.empty((nb_steps + 1, 6, nb_robots))
    states[0] = fleet.states[:6]
    control_t: list[float] = []
    velocities = []
    for step, now in enumerate(t[:-1].tolist()):
        if radio:
            radio.measure(fleet.poses, fleet.states[3], now)
        while (next_call := len(control_t) / rate) < now + Ts - _SAME_TIME_S:
            heard = radio.heard(fleet.poses, next_call) if radio else ()
            wanted, commands = controllers(fleet.poses, next_call, *heard)
            control_t.append(next_call)
            velocities.append(wanted)
            fleet.command_all(commands, now)
        fleet.step(Ts, now)
        states[step + 1] = fleet.states[:6]
        if progress:
            progress(now)
    if radio:
        radio.measure(fleet.poses, fleet.states[3], float(t[-1]))
    call_time = controllers.call_time / len(control_t)
    return OfflineRun(
        t,
        states[:, :3],
        states[:, 3],
        states[:, 5],
        np.array(control_t),
        np.array(velocities),
        call_time,
        controllers.failed_robots,
        radio.failed_robots if radio else [],
        radio.record() if radio else None,
    )
