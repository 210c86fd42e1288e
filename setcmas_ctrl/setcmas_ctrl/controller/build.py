"""Construction of a controller process: nodes, stepper of the laws, and the loop that calls it."""

from __future__ import annotations

from pathlib import Path

from setcmas_ctrl.communication.triggering import CTC
from setcmas_ctrl.control.commander import Commander
from setcmas_ctrl.controller.event_triggered_comm import EventTriggeredComm, broadcasters
from setcmas_ctrl.controller.graph_watch import GraphWatch
from setcmas_ctrl.controller.lockstep_controller import LockstepLoop
from setcmas_ctrl.controller.markers import publish_obstacles
from setcmas_ctrl.controller.network_links import FleetCommunication
from setcmas_ctrl.controller.preparation import Prepared
from setcmas_ctrl.controller.script_outcomes import ScriptOutcomes
from setcmas_ctrl.controller.script_reload import ScriptReloader
from setcmas_ctrl.controller.stepper import ControlStepper
from setcmas_ctrl.driving.driven_robot import Controller, DrivenModels, SiToUni
from setcmas_ctrl.driving.fleet_pause import FleetPause, PauseWatch
from setcmas_ctrl.driving.odometry import FleetOdometry
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.announcement import Lockstep, Scaled
from setcmas_simu.robots.arena import Arena, Obstacles
from setcmas_simu.robots.models import model_names
from setcmas_simu.ros import qos
from setcmas_simu.ros.polling import MOST_WITH_SERVICES
from setcmas_simu.ros.step_loop import ScaledClock, SteadyClock, StepClock, StepLoop


def build(known: Prepared) -> tuple[ControlStepper, StepLoop | LockstepLoop]:
    """Return the stepper of a new controller process, and what calls it, with all their nodes.

    Raises:
        SetcmasError: A model or a triggering condition cannot be loaded.
    """
    profile = qos.LOCKSTEP_COMMAND if known.in_lockstep else qos.COMMAND
    controllers = [Controller(law, profile) for law in known.laws]
    _show_obstacles(known)
    if known.wanted.safety.is_on:
        for controller in controllers:
            controller.add_allowed_topic(profile)
    odometry = _odometry(known)
    followers = _followers(known)
    pause = _pause(known, followers)
    graph = GraphWatch(known.node, odometry, known.announced, followers, known.warn)
    stepper = ControlStepper(
        known.node,
        odometry,
        list(zip(controllers, followers, strict=True)),
        _commander(known, followers),
        _outcomes(known),
        graph,
        pause,
    )
    if known.wanted.options.watch:
        timeout = known.wanted.options.pause_timeout
        launcher = known.process.launcher
        ScriptReloader(known.node, stepper, known.laws, known.loader, timeout, launcher)
    senders = _connect(known, stepper, odometry)
    if isinstance(known.time, Lockstep):
        rate = known.wanted.law.rate
        return stepper, LockstepLoop(
            known.process, known.node, odometry, stepper, senders, graph, rate, known.time
        )
    return stepper, _step_loop(known, stepper)


def _show_obstacles(known: Prepared) -> None:
    safety = known.wanted.safety
    arena = None  # that of an experiment is the bridge's to show
    if safety.arena and not known.wanted.options.experiment:
        arena = Arena(*safety.arena)
    publish_obstacles(known.node, Obstacles.of(safety.obstacles or ''), arena)


def _odometry(known: Prepared) -> FleetOdometry:
    # With event-triggered broadcast the laws know the other robots by what they send only; a
    # range is one of the radio, and of where robots are.
    return FleetOdometry(
        known.node,
        known.nb_robots,
        topics.mocap_topic if known.wanted.options.experiment else topics.odometry_topic,
        None if known.communication.needs_all_poses else known.robots,
        qos.LATCHED if known.in_lockstep else qos.STATE,
    )


def _followers(known: Prepared) -> list[SiToUni]:
    options = known.wanted.options
    profile = qos.LOCKSTEP_COMMAND if known.in_lockstep else qos.COMMAND
    topic = topics.CMD_VEL_WANTED if options.experiment else topics.CMD_VEL
    followers = [SiToUni(robot, options.cmd_vel_type, topic, profile) for robot in known.robots]
    models = DrivenModels(followers, known.warn)
    if options.model:
        models.use(model_names(options.model, known.nb_robots))
    else:
        models.follow(known.announced)
    return followers


def _commander(known: Prepared, followers: list[SiToUni]) -> Commander:
    """Return what commands the robots.

    Raises:
        SetcmasError: Some move in a way that cannot be filtered.
    """
    commander = Commander(
        known.wanted.law, known.wanted.safety, known.robots, known.nb_robots, known.warn
    )
    commander.limits = known.wanted.options.limits
    commander.use([follower.model for follower in followers])
    return commander


def _pause(known: Prepared, followers: list[SiToUni]) -> PauseWatch | None:
    """Let the fleet be paused, and each robot of a small one; return what holds an experiment."""
    pause = None
    if known.wanted.options.experiment:
        pause = PauseWatch(known.node, known.wanted.options.pause_timeout)
    else:
        FleetPause(known.node, followers, known.process.launcher, known.in_lockstep)
    if len(followers) <= MOST_WITH_SERVICES:
        for follower in followers:
            follower.offer_services()
    return pause


def _outcomes(known: Prepared) -> ScriptOutcomes:
    laws = {law.robot: law.path for law in known.laws}
    condition = known.communication.condition_script or Path(CTC)
    return ScriptOutcomes(known.warn, known.loader.watch, known.process.launcher, laws, condition)


def _connect(
    known: Prepared, stepper: ControlStepper, odometry: FleetOdometry
) -> list[EventTriggeredComm]:
    """Let the robots of this process communicate; return who sends their states when triggered."""
    communication = known.communication
    if not communication.is_ideal:
        profile = qos.LOCKSTEP_STATE if known.in_lockstep else qos.LATCHED
        stepper.communication = FleetCommunication(
            known.node, odometry, communication, known.robots, profile
        )
    if not communication.event_triggered:
        return []
    return broadcasters(
        known.robots,
        communication,
        odometry,
        stepper.outcomes.conditions,
        lambda: stepper.t,
        stepper.watch,
        known.in_lockstep,
    )


def _step_loop(known: Prepared, stepper: ControlStepper) -> StepLoop:
    clock: StepClock = SteadyClock()
    if isinstance(known.time, Scaled):
        clock = ScaledClock(known.time.rtf, known.time.begin)
    stepper.clock = clock
    loop = StepLoop(known.process, 1.0 / known.wanted.law.rate, stepper.step, clock)
    if stepper.communication:  # it counts when a state comes
        loop.poll = stepper.take
    return loop
