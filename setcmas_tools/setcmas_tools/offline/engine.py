"""Runs control laws on simulated robots without ROS: the nodes' own functions, in their order."""

from __future__ import annotations

import builtins
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from setcmas_ctrl.communication.graph import COMPLETE
from setcmas_ctrl.communication.options import CommunicationOptions, Condition, Graph
from setcmas_ctrl.communication.settings import chosen_communication
from setcmas_ctrl.communication.triggering import THRESHOLD_M
from setcmas_ctrl.control.options import RATE_HZ as CONTROL_RATE_HZ
from setcmas_ctrl.control.options import GainOptions
from setcmas_ctrl.control.saturation import VNOM
from setcmas_ctrl.scripts.output import named_output
from setcmas_ctrl.scripts.random_seed import SEED, seed_scripts
from setcmas_ctrl.scripts.settings import Settings
from setcmas_ctrl.task.references import told_references
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.planar_pose import as_heard
from setcmas_simu.options.group import ClashError
from setcmas_simu.reports.reports import Function
from setcmas_simu.robots.mixed_fleet import fleet_model
from setcmas_simu.robots.models import NO_LIMITS, absolute, check_models, model_names, robot_models
from setcmas_simu.robots.si_to_uni import KOMEGA
from setcmas_simu.robots.unicycle import RATE_HZ as ROBOT_RATE_HZ
from setcmas_simu.robots.virtual_fleet import VirtualFleet
from setcmas_simu.simulator.options import SimulationOptions
from setcmas_tools.offline import board, history
from setcmas_tools.offline.communication import OfflineCommunication
from setcmas_tools.offline.fleet_laws import Algo, FleetLaws, load_laws
from setcmas_tools.offline.given import (
    condition_name,
    failures,
    given_files,
    given_scripts,
    graph_entry,
    name_of,
    pose_options,
    script_entry,
)
from setcmas_tools.records.commands import Commands
from setcmas_tools.records.drawings import DrawingRecord
from setcmas_tools.records.fleet_table import FleetTable
from setcmas_tools.records.tables import RunTables
from setcmas_tools.run.info import RunInfo
from setcmas_tools.run.inputs import model_inputs
from setcmas_tools.run.options import RunOptions
from setcmas_tools.run.outcome import Outcome
from setcmas_tools.run.run import Run

_SAME_TIME_S = 1e-9

MAX_STATES = 10_000_000
"""The most states of robots in a run, a state a robot and step; they are held in memory."""

_BYTES_A_STATE = 500  # measured: 150 to 220, and once more while the run changes processes


def simulate(
    algo: Algo,
    nb_robots: int = 1,
    duration: float = 40.0,
    *,
    poses: ArrayLike | None = None,
    random_poses: str | None = None,
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
    threshold: float = THRESHOLD_M,
    delay: float = 0.0,
    loss: float = 0.0,
    noise: float = 0.0,
    warn: Callable[[str], None] = print,
    progress: Callable[[float], object] | None = None,
) -> Run:
    """Run a control law on simulated robots, thousands of times faster than real time.

        from setcmas_tools import simulate

        run = simulate('consensus', nb_robots=8, duration=40)
        run.poses[-1]                    # where the robots end: rows x, y, theta
        plt.plot(run.t, run.poses[:, 0]) # x of every robot over time

    As over ROS, robots have a new state at each multiple of 1/robot_rate, which the last command
    before it has led to; the laws are called at t = 0, 1/rate, 2/rate, ... with the states of that
    moment or, between two, with the older ones. Headings go through a quaternion, as messages
    carry them, and are in (-pi, pi]. Equal arguments give equal results.

    Args:
        algo: A built-in ('consensus'), a script ('my_law.py'), or a function
            control(robotNo, nbRobots, poses, t) of your own. A script is loaded afresh for each
            robot; a function is shared by all robots, and so is any state that it keeps. For a
            law of each robot: '1:leader.py,2-8:follower.py', or a dictionary {1: leader, ...}.
        nb_robots: Number of robots.
        duration: Length of the run in s.
        poses: Start poses: rows x, y in m and theta in rad, shape (3, nb_robots); by default
            those of `setcmas simu`.
        random_poses: Start at random instead: 'auto', or 'box=4x3,distance=0.5' (width and height
            of the box, and least distance between robots, in m).
        model: How the robots move: a model ('burger'), a script ('my_robot.py'), or for some of
            them '1:burger,2-4:my_robot.py'; the others are unicycles.
        limits: What unicycles can do: 'ideal', 'burger' or 'waffle'.
        vnom: Largest speed that is asked of a robot in m/s.
        komega: Gain on the heading error in 1/s.
        rate: Rate of control in Hz.
        robot_rate: Rate of the robots' steps in Hz.
        settings: Values for module-level names of the script, such as {'K': 1.2}; what the
            script derives from them follows.
        seed: Seed of the random numbers of scripts, links and start poses.
        graph: Who hears whom: 'complete', 'ring', 'path', 'star', 'directed_ring', a YAML file,
            or an adjacency matrix (row i: whom robot i hears, and with which weight).
        range: Distance in m up to which robots hear each other; None is no limit.
        event_triggered: Whether robots send their state only when a condition triggers.
        ctc: The condition: a script, or a function ctc(pos, last_pos, t); by default further away
            from the position sent last than the threshold.
        threshold: That of the default condition in m.
        delay: By how much later messages arrive, in s.
        loss: Probability that a message is lost.
        noise: Standard deviation of received positions in m.
        warn: Shows messages about a failing law; its robot is commanded zero then.
        progress: Called now and then with the time that the run has reached, in s.

    Raises:
        SetcmasError: The script cannot be loaded, or an argument makes no sense.
    """
    RunOptions(duration=duration)
    simulation = SimulationOptions(
        nb_robots=nb_robots,
        random_poses=random_poses,
        model=model,
        limits=limits,
        robot_rate=robot_rate,
        seed=seed,
    )
    gains = GainOptions(vnom=vnom, komega=komega, rate=rate, seed=seed)
    nb_steps = simulation.nb_steps(duration)
    _check_size(nb_steps, nb_robots)
    start = _start(simulation, nb_robots, poses)
    options = CommunicationOptions(
        graph=graph,
        range=range,
        event_triggered=event_triggered,
        ctc=ctc,
        threshold=threshold,
        delay=delay,
        loss=loss,
        noise=noise,
    )
    tells = chosen_communication(nb_robots, options, seed)
    names = model_names(model, nb_robots)
    check_models(names, limits)
    # Files are found before a script is loaded: it may change the current folder.
    names = absolute(names)
    inputs = [*model_inputs(model, nb_robots), *given_files(tells.condition_script, graph)]
    seed_scripts(seed)
    radio = None if tells.is_ideal else OfflineCommunication(tells, nb_robots, warn)
    with named_output(), history.recorded_drawings() as drawings:
        models = robot_models(names, builtins.range(1, nb_robots + 1), limits, warn)
        robots = fleet_model(models)
        fleet = VirtualFleet(start, robots)
        laws = load_laws(algo, nb_robots, settings)
        scripts = [(law.names, law.path) for law in laws]
        references = told_references(scripts, nb_robots, warn)
        controllers = FleetLaws(laws, robots, gains, warn)
        fleet_table, commands = _run(
            fleet, controllers, radio, nb_steps, robot_rate, rate, progress, drawings
        )
    tables = RunTables(
        fleet_table,
        commands,
        radio.record() if radio else None,
        drawings.drawings(),
        references,
    )
    outcome = Outcome.of_failures(
        failures([law.path.name for law in laws], controllers.failed_robots)
        | failures(names, [robot for robot, one in enumerate(models, 1) if one.failed]),
        {condition_name(ctc): radio.failed_robots} if radio else {},
    )
    parameters = {
        'algo': name_of(algo),
        'script': script_entry(laws),
        'set': dict(settings or {}),
        'duration': duration,
        **gains.record(),
        **options.record(),
        'ctc': name_of(ctc),
        'graph': graph_entry(graph),
        **simulation.record(),
        'pose': [] if random_poses else pose_options(start),
    }
    return Run(
        tables,
        RunInfo(outcome=outcome, parameters=parameters, seed=seed),
        (*given_scripts(laws), *inputs),
        controllers.call_time * nb_robots / len(commands.t),
    )


def _start(simulation: SimulationOptions, nb_robots: int, poses: ArrayLike | None) -> Floats:
    if poses is None:
        return simulation.start_poses(nb_robots)
    if simulation.random_poses:
        raise ClashError('{} and {} both say where robots start', 'poses', 'random_poses')
    start = np.array(poses, dtype=float)
    if start.shape != (3, nb_robots) or not np.isfinite(start).all():
        raise SetcmasError(
            f'poses have shape {start.shape}; they must be finite numbers of shape '
            f'(3, {nb_robots})'
        )
    return start


def _check_size(nb_steps: int, nb_robots: int) -> None:
    nb_states = nb_steps * nb_robots
    if nb_states > MAX_STATES:
        raise SetcmasError(
            f'the run has {nb_states:.3g} states of robots and would take about '
            f'{nb_states * _BYTES_A_STATE / 1e9:.3g} GB; it must be {MAX_STATES:.3g} at most: '
            'take a shorter duration, fewer robots, or a lower robot rate'
        )


def _run(
    fleet: VirtualFleet,
    controllers: FleetLaws,
    radio: OfflineCommunication | None,
    nb_steps: int,
    robot_rate: float,
    rate: float,
    progress: Callable[[float], object] | None,
    drawings: DrawingRecord,
) -> tuple[FleetTable, Commands]:
    nb_robots = fleet.poses.shape[1]
    t = np.arange(nb_steps + 1) / robot_rate
    control_t, due = _calls(t, 1 / robot_rate, rate)
    velocities = np.empty((len(control_t), 2, nb_robots))
    notes = board.current
    states = notes.new_states(nb_steps + 1, 6, nb_robots)
    states[0] = fleet.states[:6]
    notes.done = 1
    poses = as_heard(fleet.poses)
    if radio:
        radio.measure(poses, fleet.states[3], 0.0)

    def advance(done: int, step: int) -> Floats:
        """Move the robots from one step to a later one; returns their poses as heard."""
        notes.enter(Function.STEP)
        later = fleet.steps(1 / robot_rate, step - done)
        notes.end()
        states[done + 1 : step + 1] = later[:, :6]
        notes.done = step + 1
        if progress:
            progress(float(t[step]))
        if not radio:
            return as_heard(fleet.poses)
        heard = as_heard(later[:, :3].transpose(1, 0, 2))
        for k, now in enumerate(t[done + 1 : step + 1].tolist()):
            radio.measure(heard[:, k], later[k, 3], now)
        return heard[:, -1]

    done = 0
    for call, (now, step) in enumerate(zip(control_t.tolist(), due, strict=True)):
        if step > done:
            poses, done = advance(done, step), step
        drawings.t = now
        heard = radio.heard(poses, now) if radio else ()
        velocities[call], commands = controllers(poses, now, *heard)
        fleet.command_all(commands, now)
    advance(done, nb_steps)
    return (
        history.motion(t, states[:, :3], states[:, 3], states[:, 5]),
        history.commands(control_t, velocities),
    )


def _calls(t: Floats, Ts: float, rate: float) -> tuple[Floats, list[int]]:
    """Return the times at which laws are called, in s, and the robots' step that each precedes.

    Args:
        t: The times of the robots' states, Ts s apart.
        Ts: Period of the robots' steps.
        rate: Rate of the calls in Hz.
    """
    before = t[:-1] + Ts - _SAME_TIME_S  # calls before these times precede the robots' steps
    times = np.arange(math.ceil(before[-1] * rate) + 1) / rate
    times = times[times < before[-1]]
    return times, np.searchsorted(before, times, side='right').tolist()
