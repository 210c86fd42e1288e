"""The process of the controllers of a fleet: for each robot a controller and si_to_uni.

Start it with `ros2 run setcmas_ctrl controllers --algo consensus`.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import zip_longest
from pathlib import Path
from typing import Any

from setcmas_ctrl import drawing, network
from setcmas_ctrl.communication.communication_settings import (
    CommunicationOptions,
    chosen_communication,
)
from setcmas_ctrl.communication.triggering_conditions import CTC
from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.control.control_options import (
    SCRIPT_FAILED,
    ControllerOptions,
    GainOptions,
    LawOptions,
)
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_ctrl.controller import Controller
from setcmas_ctrl.controllers.fleet_discovery import (
    LostRobots,
    wait_for_fleet,
    wait_until,
)
from setcmas_ctrl.controllers.fleet_pause import FleetPause, PauseWatch
from setcmas_ctrl.controllers.fleet_time import FleetTime, FleetTimeTopic
from setcmas_ctrl.controllers.graph_watch import GraphWatch
from setcmas_ctrl.controllers.law_loader import LawLoader, ScriptReloader
from setcmas_ctrl.controllers.markers import MarkerCanvas, TaskTopic, publish_obstacles
from setcmas_ctrl.controllers.robot_models import DrivenModels
from setcmas_ctrl.event_triggered_comm import EventTriggeredComm
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.fleet_poses import POSE_TIMEOUT_S, FleetPoses, offered_profile
from setcmas_ctrl.network_links import FleetNetwork
from setcmas_ctrl.safety_filter_node import SafetyFilterNode
from setcmas_ctrl.script_outcomes import ScriptOutcomes, end_stuck_script
from setcmas_ctrl.scripts.call_watch import CallWatch
from setcmas_ctrl.scripts.conversion_script import ScriptConversion, script_conversions
from setcmas_ctrl.scripts.output import named_output
from setcmas_ctrl.scripts.script_errors import StopCall
from setcmas_ctrl.scripts.script_seeds import seeded_generators
from setcmas_ctrl.si_to_uni_node import REPEAT_S, SiToUni
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.reports.reports import Started
from setcmas_simu.reports.script_calls import Function
from setcmas_simu.robot_node import MOST_WITH_SERVICES, RobotNode, StepTime, stepping
from setcmas_simu.robots.arena import Arena, Obstacles
from setcmas_simu.robots.model import limits_named
from setcmas_simu.robots.models import model_names
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.parameters import NodeParameters, declare_fixed, warn_of_unknown
from setcmas_simu.ros.polling import PolledTopic, RequestWait
from setcmas_simu.ros.process import (
    SIMULATED_TIME,
    FleetNode,
    RosProcess,
    end_process,
    node_main,
)
from setcmas_simu.ros.step_loop import ScaledClock, SteadyClock, TopicClock

_SAME_RATE = 1e-6
_POLL_EVERY_S = 0.002
_AFTER_ODOMETRY_S = 0.02
_OFFERED_WITHIN_S = 0.5  # a reliable driver has usually published by then
_LISTENERS_WAIT_S = 2.0
_RECORDER_WAIT_S = 15.0  # enough for a machine that loads everything from disk first

PARAMETERS = {name: name for name in ('vnom', 'komega', 'rate')}
"""The options that are parameters of the node of the process, by parameter name."""


def main(argv: list[str] | None = None) -> int:
    """Control robots until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='controllers', description=__doc__)
    LawOptions.add_to(parser)
    ControllerOptions.add_to(parser)
    CommunicationOptions.add_to(parser)
    FilterOptions.add_to(parser)
    return node_main(parser, _control, argv)


def _control(process: RosProcess, args: argparse.Namespace) -> int:
    with seeded_generators(), named_output():
        node = FleetNode(topics.CONTROLLERS, follows_clock=True, enable_rosout=True)
        parameters = NodeParameters(node, LawOptions.of(args), PARAMETERS)
        parameters.options = law_of_parameters(node, parameters.options)
        try:
            fleet = ControlledFleet(
                process,
                node,
                parameters,
                CommunicationOptions.of(args),
                FilterOptions.of(args),
                fleet_of_parameters(node, ControllerOptions.of(args)),
            )
            fleet.run()
        except StopCall:
            return 0
        return SCRIPT_FAILED if fleet.outcomes.failed else 0


def law_of_parameters(node: FleetNode, law: LawOptions) -> LawOptions:
    """Declare parameters that say which law it is; return it, or raise SetcmasError."""
    algo = declare_fixed(node, topics.LAW, str(law.algo), 'the control law')
    exercise = declare_fixed(node, 'exercise', law.exercise, 'whether it is the exercise version')
    return replace(law, algo=algo, exercise=exercise)


def fleet_of_parameters(node: FleetNode, options: ControllerOptions) -> ControllerOptions:
    """Declare a parameter with the size of the fleet; return the options, or raise SetcmasError.

    Its value 0 stands for the size that is announced.
    """
    size = declare_fixed(node, 'nb_robots', options.nb_robots or 0, 'robots; 0: as announced')
    return replace(options, nb_robots=size or None)


class ControlledFleet:
    """The nodes that control the robots of a process, and what they share.

    Attributes:
        robots: Numbers of the robots.
        time: Time of the current step.
        poses: Newest poses of the fleet.
        network: What the robots know of each other.
        outcomes: Errors of the laws.
        controllers, si_to_unis: Nodes of the robots; no controllers without a law.
        senders: Their nodes that send states by events, if any.
        phases: All nodes that are stepped, in the order of the steps.
    """

    def __init__(
        self,
        process: RosProcess,
        node: FleetNode,
        parameters: NodeParameters[LawOptions],
        communication: CommunicationOptions,
        safety: FilterOptions,
        options: ControllerOptions,
        clock: SteadyClock | None = None,
        alone: RobotNode | None = None,
    ) -> None:
        """Find the fleet, load its laws, and create the nodes of its robots.

        Args:
            process: This process.
            node: Stands for the fleet: it has what there is once.
            parameters: Those of this node.
            communication: How the robots communicate.
            safety: The safety filter.
            options: Which robots there are, and how they listen.
            clock: Clock of the steps; by default that of the robots.
            alone: The only node, if the others of its robot are in other processes.

        Raises:
            SetcmasError: A script does not load, or options contradict each other.
            StopCall: The process was asked to stop meanwhile.
        """
        process.requests = RequestWait([node])
        self._process, self._node, self._warn = process, node, node.get_logger().warning
        self._parameters, self._options, self._safety = parameters, options, safety
        self._alone = alone
        law = parameters.options
        communication = communication.found(law.exercise)
        scripts = None if law.is_external else law.scripts()
        self._announced = FleetListener(node)
        self._nb_robots = options.nb_robots or self._found_fleet()
        self.robots = options.controlled(self._nb_robots)
        self._communication = chosen_communication(self._nb_robots, communication, law.seed)
        self._watch = CallWatch(self._warn, process.launcher)
        end_stuck_script(process, self._watch)
        drawing.canvas = MarkerCanvas(node)
        self._loader, laws = None, []
        if scripts:
            self._loader = self._law_loader(scripts)
            laws = self._loader.load()
        if options.nb_robots and not options.experiment:  # laws load before there is a fleet
            self._found_fleet()
        self._of_nodes: dict[str, Any] = {
            'fleet': node,
            'time': StepTime(1.0 / law.rate, clock or self._clock_of_robots()),
            'has_services': len(self.robots) <= MOST_WITH_SERVICES,
        }
        self.time: StepTime = self._of_nodes['time']
        if alone:
            alone.time = self.time
        self.outcomes = ScriptOutcomes(
            self._warn,
            self._watch,
            process.launcher,
            {one.robot: one.path for one in laws},
            self.robots,
            self._communication.condition_script or Path(CTC),
            Path(str(law.conversion())),
        )
        self._create_nodes(laws)
        self._parameters.on_change = self._follow
        nodes = [node, *itertools.chain(*self.phases, self.senders)]
        warn_of_unknown(nodes)
        self._watch_graph()
        process.requests = RequestWait(nodes, self._urgent)  # while they wait, too
        self._reloader = self._reload_on_save(laws)

    def _found_fleet(self) -> int:
        """Wait for the fleet; return its size, which is the given one if there is one."""
        given = self._options.nb_robots
        nb_robots = wait_for_fleet(self._process, self._node, self._announced, given)
        _go_on(nb_robots)
        return max(nb_robots, self._alone.robot if self._alone else 0)  # it may come later

    def _clock_of_robots(self) -> SteadyClock:
        if self._announced.rtf != 1.0:
            return ScaledClock(self._announced.rtf, self._announced.begin)
        if not self._node.get_parameter(SIMULATED_TIME).value:
            return SteadyClock()
        clock = TopicClock(self._node)
        text = f'waiting for the time on {topics.CLOCK} ({SIMULATED_TIME}); is it published?'
        _go_on(wait_until(self._process, clock.has_begun, lambda: self._warn(text)))
        return clock

    def _law_loader(self, scripts: LawScripts) -> LawLoader:
        scripts.check(self._nb_robots)
        task = TaskTopic(self._node, self._nb_robots)
        seed = self._parameters.options.seed
        return LawLoader(scripts, seed, self.robots, self._nb_robots, self._watch, task)

    def _create_nodes(self, laws: Sequence[ControlLaw]) -> None:
        law, safety, options = self._parameters.options, self._safety, self._options
        limits = options.limits or limits_named(self._announced.limits)
        own, of_nodes = options.experiment, self._of_nodes
        self.controllers: list[Controller] = []
        self.si_to_unis: list[SiToUni] = []
        self.senders: list[EventTriggeredComm] = []
        for robot in self.robots if self._alone is None else ():
            if laws:
                self.controllers.append(Controller(robot, law, own, **of_nodes))
            self.si_to_unis.append(SiToUni(robot, law, safety, options, limits, **of_nodes))
            if self._communication.event_triggered:
                self.senders.append(EventTriggeredComm(robot, own, **of_nodes))
        if isinstance(self._alone, Controller):
            self.controllers.append(self._alone)
        elif isinstance(self._alone, SiToUni):
            self.si_to_unis.append(self._alone)
        elif isinstance(self._alone, EventTriggeredComm):
            self.senders.append(self._alone)
        self.poses = self._subscribed_poses()
        for si_to_uni, script in zip_longest(self.si_to_unis, self._conversions()):
            si_to_uni.poses = self.poses
            if script:
                si_to_uni.convert_by(script)
        self.network = FleetNetwork(self._node, self.poses, self._communication, self.robots)
        for controller, one in zip(self.controllers, laws, strict=True):
            controller.law, controller.network, controller.outcomes = (
                one,
                self.network,
                self.outcomes,
            )
        self._load_conditions()
        self.network.senders = {sender.robot: sender for sender in self.senders}
        self._models = DrivenModels(self.si_to_unis, self._warn)
        if options.model:
            self._models.use(model_names(options.model, self._nb_robots))
        else:
            self._models.follow(self._announced)
        filters = [self._safety_filter()] if safety.is_on else []
        self.phases: list[Sequence[Any]] = [self.controllers, filters, self.si_to_unis]
        arena = None  # that of an experiment is the bridge's to show
        if safety.arena and not options.experiment:
            arena = Arena(*safety.arena)
        publish_obstacles(self._node, Obstacles.of(safety.obstacles or ''), arena)

    @property
    def _topic_of(self) -> Callable[[int], str]:
        """The topic with the poses of a robot that is not told another one."""
        return topics.mocap_topic if self._options.experiment else topics.odometry_topic

    def _subscribed_poses(self) -> FleetPoses:
        """Return the poses of all robots that the laws, their links or the filter need."""
        profile, topic_of = qos.STATE, self._topic_of
        if not (self._options.experiment or self._announced.robots):  # robots of others
            profile = offered_profile(self._node, topic_of(self.robots[0]))
        sources: dict[int, tuple[FleetNode, str]] = {}
        needs_all = self.controllers and self._communication.needs_all_poses
        if needs_all or self._safety.is_on:
            everyone = range(1, self._nb_robots + 1)
            sources = {robot: (self._node, topic_of(robot)) for robot in everyone}
        sources |= {one.robot: (one, one.odom_topic) for one in self.senders}
        sources |= {one.robot: (one, one.odom_topic) for one in self.si_to_unis}
        sources |= {one.robot: (one, one.odom_topic) for one in self.controllers}
        return FleetPoses(sources, self._nb_robots, profile)

    def _conversions(self) -> list[ScriptConversion]:
        """Return a user's own conversion for each robot, each with its own state, if any."""
        return script_conversions(
            self._parameters.options.conversion(),
            [one.robot for one in self.si_to_unis],
            self.outcomes.conversions,
            lambda: self.time.t,
            partial(self._watch.call, function=Function.SI_TO_UNI),
        )

    def _load_conditions(self) -> None:
        """Let robots send their states when their conditions trigger."""
        path = self._communication.condition_script or Path(CTC)
        for sender in self.senders:
            sender.watch = self._watch
            with self._watch.loading(sender.robot, path):
                sender.broadcast = self._communication.broadcast(
                    sender.robot, self.outcomes.conditions
                )
            self.poses.listen(sender.robot, sender.evaluate)

    def _safety_filter(self) -> SafetyFilterNode:
        return SafetyFilterNode(
            self._node,
            self.si_to_unis,
            self._safety,
            self._parameters.options,
            self.poses,
            self._conversions(),
        )

    def _watch_graph(self) -> None:
        process, node, robots = self._process, self._node, self.si_to_unis
        self._graph = GraphWatch(
            node, self.poses, self._topic_of, self._announced, robots, self._warn
        )
        self._graph.is_of_one = self._alone is not None
        self._lost = LostRobots(self.robots, self.poses, self._warn)
        self._urgent: list[PolledTopic] = []
        if self._options.experiment:
            pause = PauseWatch(node, self._options.pause_timeout)
            self._is_paused: Callable[[], bool] = lambda: pause.reason() != ''
        else:
            fleet_pause = FleetPause(node, robots, process.launcher)
            self._urgent += fleet_pause.topics
            self._is_paused = lambda: fleet_pause.is_on
        self._run_time, self._time_topic = FleetTime(), None
        if len(self.robots) < self._nb_robots:  # other processes may control the others
            self._time_topic = FleetTimeTopic(
                node, self.robots, self._run_time, self.time.clock.now
            )
            self._urgent.append(self._time_topic.topic)
        self._stepped = self.time.clock.now()

    def _reload_on_save(self, laws: Sequence[ControlLaw]) -> ScriptReloader | None:
        if not (self._options.watch and self._loader):
            return None
        return ScriptReloader(
            self._node,
            self,
            laws,
            self._loader,
            self._communication,
            self.senders,
            self._options.pause_timeout,
        )

    def get_ready(self) -> None:
        """Wait until all poses are known, the robots listen, and a recorder, if there is one."""
        process, poses, graph = self._process, self.poses, self._graph
        process.spin_until(lambda: not self._taken(poses.missing), _OFFERED_WITHIN_S)
        poses.accept_best_effort(poses.missing())
        self._await('odometry', poses.missing, poses.topic_of, self._odometry_hint)
        if self.controllers:
            state_of = partial(topics.robot_topic, topic=topics.TRIG_ODOM)
            self._await('states', self.network.missing, state_of, _sent_hint)
        # The robots, and a recorder if there is one, must get the very first command.
        process.spin_until(graph.all_connected(), _LISTENERS_WAIT_S)
        recorded = self._options.recorded
        wait_s = _RECORDER_WAIT_S if recorded else _LISTENERS_WAIT_S
        process.spin_until(graph.all_recorded(recorded), wait_s)
        if self._time_topic:
            self._time_topic.wait_for_others(process)
        _go_on(not process.stopping)
        # Log now, not between the odometry and t = 0: logging takes time.
        paths = [one.law.path for one in self.controllers if one.law]
        law = ', '.join(dict.fromkeys(path.stem for path in paths)) or 'velocities of others'
        robots = robots_in_words(self.robots)
        task = f'controlling {robots} with {law} at {self._parameters.options.rate:g} Hz'
        if not (self.controllers or self.si_to_unis):
            task = f'sending the states of {robots} by events'
        self._node.get_logger().info(f'{task}; Ctrl-C stops')
        process.launcher.report(Started(tuple(self.robots), law))
        self._fall_in_step()
        self._stepped = self.time.clock.now()

    def _await(
        self,
        what: str,
        missing: Callable[[], list[int]],
        topic_of: Callable[[int], str],
        hint: Callable[[list[int]], str],
    ) -> None:
        """Wait until no robot is missing; name those that are, now and then, with a hint."""

        def remind() -> None:
            robots = missing()
            text = f'waiting for the {what} of {robots_in_words(robots)} ({topic_of(robots[0])})'
            self._warn(f'{text}; {hint(robots)}')

        _go_on(wait_until(self._process, lambda: not self._taken(missing), remind))

    def _taken(self, missing: Callable[[], list[int]]) -> list[int]:
        self.take()
        return missing()

    def _odometry_hint(self, robots: list[int]) -> str:
        self.poses.accept_best_effort(robots)
        for robot in robots:
            if fault := self.poses.fault(robot):
                return f'robot {robot} sends invalid odometry: {fault}'
        if self._options.experiment:
            return f'does motion capture see {"it" if len(robots) == 1 else "them"}?'
        return 'is the simulator running?'

    def _fall_in_step(self) -> None:
        """Wait until shortly after the next odometry of a robot.

        Robots and laws step on clocks that run alike, at rates that divide each other, so that
        from then on every call sees fresh poses, and its commands arrive before the robots' next
        step.
        """
        self.take()

        def is_new() -> bool:
            self.take()
            return self.poses.age(self.robots[0]) == 0.0

        self._process.spin_until(is_new, 1.0, _POLL_EVERY_S)
        clock = self.time.clock
        begin = clock.now()
        self._process.spin_until(
            lambda: clock.now() - begin >= _AFTER_ODOMETRY_S, 1.0, _POLL_EVERY_S
        )

    def run(self) -> None:
        """Control the robots until the process must stop; then they rest."""
        self._process.take_signals()  # scripts may have changed the handlers while loading
        end_stuck_script(self._process, self._watch)
        try:
            with contextlib.suppress(StopCall), network.exchanged_by(self.network):
                self.get_ready()
                self._parameters.check = self._check
                self._set_rate(self._parameters.options.rate)
                self.network.on_begin = self._poll_often
                self._loop = stepping(
                    self._process,
                    self.time,
                    self.phases,
                    self.begin_step,
                    self.end_step,
                )
                if self.network.is_on or not self.controllers or self.time.period > REPEAT_S:
                    self._poll_often()
                self._loop.run()
        finally:
            if self._process.can_talk:
                self.stop()
            self._watch.close()
        self.outcomes.end()

    def _poll_often(self) -> None:
        """Take messages between steps: it counts when a state comes; velocities cannot wait."""
        self._loop.poll = self._poll

    def _poll(self) -> None:
        self.take()
        self.time.begin_step(self.time.clock.now())
        for phase in self.phases[1:] if not self.controllers else self.phases[2:]:
            for node in phase:
                node.step()

    def take(self) -> None:
        """Take pending messages: poses, states and messages that robots have sent."""
        now = self.time.clock.now()
        self.time.t = self._run_time.at(now)
        self.network.take_values()
        self.poses.take(now)
        self.network.take()
        self._announced.take()

    def begin_step(self) -> None:
        """Take messages, and prepare the nodes for the step at the present time."""
        now = self.time.now
        self._watch.begin_period()
        self.take()
        # A step cannot receive odometry while it runs.
        self._lost.update(POSE_TIMEOUT_S + now - self._stepped)
        is_paused = self._is_paused()
        self.time.t = t = self._run_time.step(now, is_paused)
        if not is_paused:
            self.network.begin_step(t)
        for controller in self.controllers:
            controller.is_paused = is_paused
            controller.is_lost = controller.robot in self._lost

    def end_step(self) -> None:
        """Look after what is not urgent."""
        self._watch.end_period()
        if self._time_topic and self.controllers:
            self._time_topic.publish()
        self._stepped = self.time.now
        self._process.take_signals()  # scripts may have changed the handlers
        self._graph.check()
        if self._reloader:
            self._reloader.poll()

    @property
    def shares_t(self) -> bool:
        """Whether other processes use the same t."""
        return self._run_time.is_shared(self.time.clock.now())

    def use(self, laws: Sequence[ControlLaw]) -> None:
        """Replace the laws, and reset t and errors; without laws all robots stop."""
        self.outcomes.begin_anew(loaded=bool(laws))
        by_robot = {law.robot: law for law in laws}
        for controller in self.controllers:
            controller.law = by_robot.get(controller.robot)
        self._run_time.begin_anew()
        self.network.forget_messages()

    def stop(self) -> None:
        """Let every robot rest, its controller first."""
        for phase in self.phases:
            for node in phase:
                node.stop()
        self.network.stop()

    def _check(self, options: GainOptions) -> None:
        """Check that the rate of an experiment does not change.

        Raises:
            SetcmasError: It would change.
        """
        rate = 1.0 / self.time.period
        if self._options.experiment and abs(options.rate - rate) > _SAME_RATE:
            raise SetcmasError(
                f'rate is fixed at {rate:g} Hz during an experiment, because robots stop when '
                'commands are late; restart it with another --rate'
            )

    def _follow(self, options: GainOptions) -> None:
        """Let the nodes of all robots have these gains and this rate."""
        self._set_rate(options.rate)
        for phase in self.phases:
            for node in phase:
                if node is not self._node:
                    node.parameters.follow(options)

    def _set_rate(self, rate: float) -> None:
        self.time.period = 1.0 / rate
        self._watch.slow.period = self.time.period / self.time.clock.rtf
        for phase in self.phases[1:]:  # the acceleration of robots depends on it
            for node in phase:
                node.conversion.Ts = self.time.period


def _sent_hint(_: list[int]) -> str:
    return 'is a controller running with --event-triggered?'


def _go_on(found: object) -> None:
    """End the process if nothing was found: then it was asked to stop."""
    if not found:
        raise StopCall


def run_process() -> None:
    """Run `main` and end the process."""
    end_process(main())


if __name__ == '__main__':
    run_process()
