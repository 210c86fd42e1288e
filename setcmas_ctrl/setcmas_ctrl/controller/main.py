"""The controller: poses of the fleet in, the velocity that a control script wants out.

A process holds a controller and a si_to_uni node for each of its robots, and an
event_triggered_comm node if it is to. Run as
`ros2 run setcmas_ctrl controller --algo consensus`.
"""

from __future__ import annotations

import argparse
import contextlib
import math
from functools import partial
from pathlib import Path

import rclpy
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from setcmas_ctrl import drawing
from setcmas_ctrl.communication.options import CommunicationOptions
from setcmas_ctrl.communication.settings import Communication, chosen_communication
from setcmas_ctrl.communication.triggering import CTC
from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_ctrl.control.options import SCRIPT_FAILED, ControllerOptions, GainOptions, LawOptions
from setcmas_ctrl.controller.canvas import MarkerCanvas
from setcmas_ctrl.controller.communication import FleetCommunication
from setcmas_ctrl.controller.controller import Controller
from setcmas_ctrl.controller.driven_models import DrivenModels
from setcmas_ctrl.controller.event_triggered_comm import EventTriggeredComm, broadcasters
from setcmas_ctrl.controller.graph_watch import GraphWatch
from setcmas_ctrl.controller.lockstep_loop import LockstepLoop
from setcmas_ctrl.controller.reloader import ScriptReloader
from setcmas_ctrl.controller.script_outcomes import ScriptOutcomes
from setcmas_ctrl.controller.si_to_uni import SiToUni
from setcmas_ctrl.controller.stepper import ControlStepper
from setcmas_ctrl.controller.stuck_scripts import end_process, end_stuck_script
from setcmas_ctrl.fleet.discovery import (
    wait_for_announcement,
    wait_for_fleet,
    wait_for_source,
)
from setcmas_ctrl.fleet.odometry import FleetOdometry
from setcmas_ctrl.fleet.pause_watch import PauseWatch
from setcmas_ctrl.scripts.call_watch import CallWatch
from setcmas_ctrl.scripts.output import named_output
from setcmas_ctrl.scripts.random_seed import seed_scripts
from setcmas_ctrl.scripts.stop_call import StopCall
from setcmas_ctrl.task.task_topic import TaskTopic
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.announcement import Lockstep, Scaled
from setcmas_simu.messages.fleet_topic import FleetListener
from setcmas_simu.messages.polled_service import MOST_WITH_SERVICES
from setcmas_simu.reports.launcher import Launcher
from setcmas_simu.reports.reports import Paused
from setcmas_simu.robots.models import model_names
from setcmas_simu.ros import qos
from setcmas_simu.ros.parameters import ProcessParameters, fixed_in_lockstep
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main
from setcmas_simu.ros.step_clock import ScaledClock, SteadyClock
from setcmas_simu.ros.step_loop import StepLoop

PARAMETERS = {name: name for name in ('vnom', 'komega', 'rate')}
"""The options that are parameters of the process's node, by the parameter's name."""


def load_laws(
    seed: int,
    scripts: LawScripts,
    robots: list[int],
    nb_robots: int,
    watch: CallWatch,
    task: TaskTopic,
) -> list[ControlLaw]:
    """Return the control laws of the robots of this process, with fresh state; tell their task.

    Raises:
        SetcmasError: The script cannot be loaded, or has shut ROS down.
    """
    seed_scripts((seed + robots[0] - 1) % 2**32)  # in another process, other numbers
    laws = []
    for robot in robots:
        with watch.loading(robot, scripts.script(robot)):
            laws.append(scripts.law(robot, nb_robots))
        if not rclpy.ok():
            raise SetcmasError(
                f'{scripts.script(robot).name} has shut ROS down while loading: leave out '
                'rclpy.shutdown'
            )
    with watch.loading(robots[0], scripts.script(robots[0])):
        task.tell(laws)
    return laws


def build(
    args: argparse.Namespace, process: RosProcess, node: FleetNode, law: LawOptions
) -> tuple[ControlStepper, StepLoop | LockstepLoop] | None:
    """Return the stepper of a new controller process, and what calls it, with all their nodes.

    Returns:
        None if it was asked to stop meanwhile.

    Raises:
        SetcmasError: The script cannot be loaded, or options contradict each other.
    """
    options = ControllerOptions.of(args)
    heard = CommunicationOptions.of(args).found(law.exercise)
    scripts = law.scripts()
    process.add(node)
    announced = FleetListener(node)
    # Nothing is commanded to robots of somebody else's simulator.
    if options.simulator and not wait_for_source(process, node, announced, options.simulator):
        return None
    nb_robots = options.nb_robots or wait_for_fleet(process, node, announced)
    if not nb_robots:
        return None
    robots = options.controlled(nb_robots)
    scripts.check(nb_robots)
    drawing.canvas = canvas = MarkerCanvas(node)
    watch = CallWatch(math.inf, node.get_logger().warning, process.launcher)
    end_stuck_script(process, watch)
    load = partial(
        load_laws, law.seed, scripts, robots, nb_robots, watch, TaskTopic(node, nb_robots)
    )
    laws = load()
    communication = chosen_communication(nb_robots, heard, law.seed)
    if not options.experiment and not wait_for_announcement(process, node, announced, nb_robots):
        return None
    time = None if options.experiment else announced.time
    lockstep = isinstance(time, Lockstep)
    if not lockstep:  # there time waits for them
        rtf = time.rtf if isinstance(time, Scaled) else 1.0
        watch.slow.period = 1 / law.rate / rtf
    if lockstep:
        check_lockstep(options, communication, nb_robots)
        canvas.profile = qos.LOCKSTEP_STATE  # a recorder gets the first ones, too
    profile = qos.LOCKSTEP_COMMAND if lockstep else qos.COMMAND
    controllers = [Controller(law, profile) for law in laws]
    # With event-triggered broadcast the laws know the other robots by what they send only; a
    # range is one of the radio, and of where robots are.
    odometry = FleetOdometry(
        node,
        nb_robots,
        topics.mocap_topic if options.experiment else topics.odometry_topic,
        None if communication.needs_all_poses else robots,
        qos.LATCHED if lockstep else qos.STATE,
    )
    command = topics.CMD_VEL_WANTED if options.experiment else topics.CMD_VEL
    followers = [SiToUni(robot, options.cmd_vel_type, command, profile) for robot in robots]
    models = DrivenModels(followers, node.get_logger().warning)
    if options.model:
        models.use(model_names(options.model, nb_robots))
    else:
        models.follow(announced)
    pause = PauseWatch(node, options.pause_timeout) if options.experiment else None
    if not pause and not lockstep:  # there time itself stands
        _follow_pause(node, followers, process.launcher)
    if len(followers) <= MOST_WITH_SERVICES:
        for follower in followers:
            follower.offer_services()
    paths = {robot: scripts.script(robot) for robot in robots}
    condition = communication.condition_script or Path(CTC)
    outcomes = ScriptOutcomes(node.get_logger().warning, watch, process.launcher, paths, condition)
    graph = GraphWatch(node, odometry, announced, followers, node.get_logger().warning)
    pairs = list(zip(controllers, followers, strict=True))
    stepper = ControlStepper(node, odometry, pairs, law, outcomes, graph, pause)
    if law.watch:
        tell = process.launcher.tell
        ScriptReloader(node, stepper, laws, load, watch, options.pause_timeout, tell)
    senders = connect(stepper, communication, robots, node, odometry, lockstep)
    if isinstance(time, Lockstep):
        return stepper, LockstepLoop(
            process, node, odometry, stepper, senders, graph, law.rate, time
        )
    clock = ScaledClock(time.rtf, time.begin) if time else SteadyClock()
    stepper.clock = clock
    loop = StepLoop(process, stepper.period, stepper.step, clock)
    if stepper.communication:  # it counts when a state comes
        loop.poll = stepper.take
    return stepper, loop


def check_lockstep(
    options: ControllerOptions, communication: Communication, nb_robots: int
) -> None:
    """See that a controller can follow a simulator in lockstep.

    Raises:
        SetcmasError: It cannot.
    """
    if options.cmd_vel_type == 'twist':
        raise SetcmasError(
            'the simulator is in lockstep and needs commands with a stamp: '
            '--cmd-vel-type must be twist_stamped'
        )
    if communication.event_triggered and len(options.controlled(nb_robots)) < nb_robots:
        raise SetcmasError(
            'the simulator is in lockstep: event-triggered robots must all be controlled by one '
            'process; leave out --robots'
        )


def connect(
    stepper: ControlStepper,
    communication: Communication,
    robots: list[int],
    node: FleetNode,
    odometry: FleetOdometry,
    lockstep: bool = False,
) -> list[EventTriggeredComm]:
    """Let the robots of this process communicate as they are asked to.

    Returns:
        The nodes that send their states when a condition triggers.

    Raises:
        SetcmasError: A triggering condition cannot be loaded.
    """
    if not communication.is_ideal:
        profile = qos.LOCKSTEP_STATE if lockstep else qos.LATCHED
        stepper.communication = FleetCommunication(node, odometry, communication, robots, profile)
    if not communication.event_triggered:
        return []
    reports = stepper.outcomes.conditions
    return broadcasters(
        robots, communication, odometry, reports, lambda: stepper.t, stepper.watch, lockstep
    )


def _follow_pause(node: FleetNode, followers: list[SiToUni], launcher: Launcher) -> None:
    """Pause the fleet, or let it go on, as /pause says; tell so, as it may come from elsewhere."""

    def pause(paused: bool, by: str) -> None:
        if any(follower.paused != paused for follower in followers):
            print(f'{"paused" if paused else "started"} by {by}', flush=True)
            launcher.tell(Paused(paused))
        for follower in followers:
            follower.pause(paused)

    def answer(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        pause(request.data, 'service')
        response.success = True
        response.message = f'all robots are {"paused" if request.data else "let go"}'
        return response

    node.create_subscription(
        Bool, topics.FLEET_PAUSE, lambda message: pause(message.data, '/pause'), qos.EVENT
    )
    node.create_service(SetBool, '~/pause', answer)


def _follow(stepper: ControlStepper, loop: StepLoop, gains: GainOptions) -> None:
    stepper.follow(gains)
    loop.period = stepper.period


def _keep_rate(rate: float, gains: GainOptions) -> None:
    """See that nobody changes the rate of an experiment.

    Raises:
        SetcmasError: Somebody does.
    """
    if gains.rate != rate:
        raise SetcmasError(
            f'rate is {rate:g} Hz for the whole experiment, since robots stop without commands '
            'in time; start it again with another --rate'
        )


def main(argv: list[str] | None = None) -> int:
    """Control robots until a signal arrives; returns the exit status."""
    parser = argparse.ArgumentParser(prog='controller', description=__doc__)
    LawOptions.add_to(parser)
    ControllerOptions.add_to(parser)
    CommunicationOptions.add_to(parser)
    return node_main(parser, _control, argv)


def _control(process: RosProcess, args: argparse.Namespace) -> int:
    with named_output():
        node = FleetNode.of_process('controllers')
        parameters = ProcessParameters(node, LawOptions.of(args), PARAMETERS)
        if args.experiment:
            parameters.check = partial(_keep_rate, parameters.options.rate)
        try:
            built = build(args, process, node, parameters.options)
        except StopCall:
            return 0
        if built is None:
            return 0
        stepper, loop = built
        process.take_signals()  # scripts may have taken them while they were loaded
        end_stuck_script(process, stepper.watch, stepper.stop)
        try:
            with contextlib.suppress(StopCall):
                stepper.get_ready(process, args.recorded, isinstance(loop, LockstepLoop))
                if isinstance(loop, StepLoop):
                    parameters.on_change = partial(_follow, stepper, loop)
                    _follow(stepper, loop, parameters.options)  # it may have changed meanwhile
                else:
                    parameters.check = fixed_in_lockstep
                loop.run()
        finally:
            if process.can_talk:
                stepper.stop()
                if isinstance(loop, LockstepLoop):
                    loop.leave()
            stepper.watch.close()
        stepper.outcomes.end()
        return SCRIPT_FAILED if stepper.outcomes.failed else 0


def run() -> None:
    """Run `main` and end the process."""
    end_process(main())


if __name__ == '__main__':
    run()
