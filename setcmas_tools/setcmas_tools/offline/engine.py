"""Runs control laws on simulated robots without ROS: the nodes' own functions, in their order."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from setcmas_ctrl.communication.communication_options import Condition, Graph
from setcmas_ctrl.communication.graph import COMPLETE
from setcmas_ctrl.communication.triggering import THRESHOLD_M
from setcmas_ctrl.control.commander import Commander
from setcmas_ctrl.control.control_options import RATE_HZ as CONTROL_RATE_HZ
from setcmas_ctrl.control.saturation import VNOM
from setcmas_ctrl.filter.filter_options import GAMMA, LOOKAHEAD_M, NONE
from setcmas_ctrl.scripts.loader import SEED, seed_scripts
from setcmas_ctrl.scripts.output import named_output
from setcmas_ctrl.scripts.script_settings import Settings
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.planar_pose import through_quaternion
from setcmas_simu.reports.reports import Function
from setcmas_simu.robots.model import KOMEGA
from setcmas_simu.robots.models import NO_LIMITS, fleet_model
from setcmas_simu.robots.unicycle import RATE_HZ as ROBOT_RATE_HZ
from setcmas_simu.robots.virtual_fleet import VirtualFleet
from setcmas_tools.offline import board, history
from setcmas_tools.offline.communication import OfflineCommunication
from setcmas_tools.offline.fleet_laws import Algo, FleetLaws
from setcmas_tools.offline.simulation import Simulation
from setcmas_tools.run.law_output import DrawingRecord
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_tables import RunTables

_SAME_TIME_S = 1e-9


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
    filter: str | None = None,  # noqa: A002
    deadlock: str = NONE,
    min_separation: float | None = None,
    gamma: float = GAMMA,
    lookahead: float = LOOKAHEAD_M,
    arena: Sequence[float] | None = None,
    obstacles: str | None = None,
    accel: float | None = None,
    warn: Callable[[str], None] = print,
    progress: Callable[[float], object] | None = None,
) -> Run:
    """Run a control law on simulated robots, hundreds of times faster than real time.

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
        ctc: The condition: a script, a function ctc(pos, last_pos, t), or a dictionary with one
            for each robot; by default further away from the position sent last than the threshold.
        threshold: That of the default condition in m.
        delay: By how much later messages arrive, in s.
        loss: Probability that a message is lost.
        noise: Standard deviation of received positions in m.
        filter: 'barrier' keeps robots apart, in the arena and off obstacles: the smallest change
            of what is wanted that does. It goes by true poses, whatever robots hear.
        deadlock: 'turn' lets robots that block each other go round to the right.
        min_separation: Least distance between the centres of two robots in m, by default 0.35;
            half of it to obstacles.
        gamma: How fast robots may use up the distance that is left, in 1/s.
        lookahead: How far ahead of its axle a unicycle is kept from others, in m.
        arena: Where robots may be: xmin, xmax, ymin, ymax in m.
        obstacles: What they must not touch: 'disc 1 2 0.5; polygon 0 0 1 0 1 1' in m, or a file.
        accel: How fast the speed of a robot may rise, in m/s^2; slowing down has no limit.
        warn: Shows messages about a failing law, whose robot is commanded zero then, and about
            robots that block each other.
        progress: Called now and then with the time that the run has reached, in s.

    Raises:
        SetcmasError: The script cannot be loaded, or an argument makes no sense.
    """
    one = Simulation(**locals())
    seed_scripts(seed)
    radio = None
    if not one.tells.is_ideal:
        radio = OfflineCommunication(one.tells, nb_robots, warn)
    with named_output(), history.recorded_drawings() as drawings:
        one.load()
        return _run(one, radio, drawings)


def _run(one: Simulation, radio: OfflineCommunication | None, drawings: DrawingRecord) -> Run:
    """Make a run whose scripts are loaded.

    Args:
        one: The run.
        radio: How its robots communicate; None if each knows the poses of all.
        drawings: Takes what its scripts draw.
    """
    nb_robots = one.nb_robots
    fleet = VirtualFleet(one.start, fleet_model(one.models))
    robots = range(1, nb_robots + 1)
    commander = Commander(one.gains, one.safety, robots, nb_robots, one.warn)
    commander.use(one.models)
    controllers = FleetLaws(one.laws, commander, one.warn)
    t, states, control_t, velocities = _moved(fleet, controllers, radio, one, drawings)
    tables = RunTables(
        history.motion(t, states[:, :3], states[:, 3], states[:, 5]),
        history.commands(control_t, velocities),
        radio.record() if radio else None,
        drawings.drawings(),
    )
    call_time = controllers.call_time * nb_robots / len(control_t)
    conditions = radio.reports if radio else None
    return one.run(tables, call_time, controllers.reports, conditions)


def _moved(
    fleet: VirtualFleet,
    controllers: FleetLaws,
    radio: OfflineCommunication | None,
    given: Simulation,
    drawings: DrawingRecord,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return times and states of the robots, and what `history.commands` takes."""
    nb_steps, robot_rate, progress = given.nb_steps, given.robot_rate, given.progress
    nb_robots = fleet.poses.shape[1]
    t = np.arange(nb_steps + 1) / robot_rate
    control_t, due = _calls(t, 1 / robot_rate, given.rate)
    velocities = np.empty((len(control_t), 5 if given.safety.is_on else 2, nb_robots))
    notes = board.current
    states = notes.new_states(nb_steps + 1, 6, nb_robots)
    states[0] = fleet.states[:6]
    notes.done = 1
    poses = through_quaternion(fleet.poses)
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
            return through_quaternion(fleet.poses)
        heard = through_quaternion(later[:, :3].transpose(1, 0, 2))
        for k, now in enumerate(t[done + 1 : step + 1].tolist()):
            radio.measure(heard[:, k], later[k, 3], now)
        return heard[:, -1]

    done = 0
    for call, (now, step) in enumerate(zip(control_t.tolist(), due, strict=True)):
        if step > done:
            poses, done = advance(done, step), step
        drawings.t = now
        heard = radio.known_poses(poses, now) if radio else ()
        commanded = controllers(poses, now, *heard)
        velocities[call, :2] = commanded.wanted
        if commanded.allowed is not None:
            velocities[call, 2:] = commanded.allowed
        fleet.command_all(commanded.commands, now)
    advance(done, nb_steps)
    return t, states, control_t, velocities


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
