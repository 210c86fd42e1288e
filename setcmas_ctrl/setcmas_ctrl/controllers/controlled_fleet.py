"""The nodes that control the robots of a process, and what they share."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from setcmas_ctrl import drawing
from setcmas_ctrl.communication.communication_settings import (
    CommunicationOptions,
    chosen_communication,
)
from setcmas_ctrl.communication.triggering_conditions import CTC
from setcmas_ctrl.controller import Controller
from setcmas_ctrl.controllers.fleet_discovery import LostRobots, go_on, wait_for_fleet, wait_until
from setcmas_ctrl.controllers.fleet_pause import FleetPause
from setcmas_ctrl.controllers.fleet_time import FleetTime, FleetTimeTopic
from setcmas_ctrl.controllers.graph_watch import GraphWatch
from setcmas_ctrl.controllers.law_loader import LawLoader, ScriptReloader
from setcmas_ctrl.controllers.markers import MarkerCanvas, TaskTopic, publish_obstacles
from setcmas_ctrl.controllers.robot_models import DrivenModels
from setcmas_ctrl.event_triggered_comm import EventTriggeredComm
from setcmas_ctrl.experiment_pause import PauseWatch
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.fleet_poses import POSE_TIMEOUT_S, FleetPoses
from setcmas_ctrl.laws.call_watch import CallWatch
from setcmas_ctrl.laws.control_law import ControlLaw
from setcmas_ctrl.laws.control_options import ControllerOptions, GainOptions, LawOptions
from setcmas_ctrl.laws.conversion_script import ScriptConversion, script_conversions
from setcmas_ctrl.laws.law_scripts import LawScripts
from setcmas_ctrl.network_links import FleetNetwork
from setcmas_ctrl.predictions.prediction import doubts_at_start
from setcmas_ctrl.safety_filter_node import SafetyFilterNode
from setcmas_ctrl.script_outcomes import ScriptOutcomes, end_stuck_script
from setcmas_ctrl.si_to_uni_node import REPEAT_S, SiToUni
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.reports.script_calls import Function
from setcmas_simu.robot_node import MOST_WITH_SERVICES, RobotNode, StepTime
from setcmas_simu.robots.arena import Arena, Obstacles
from setcmas_simu.robots.model import limits_named
from setcmas_simu.robots.models import model_names
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.parameters import NodeParameters, warn_of_unknown
from setcmas_simu.ros.polling import PolledTopic, RequestWait
from setcmas_simu.ros.process import SIMULATED_TIME, FleetNode, RosProcess
from setcmas_simu.ros.step_loop import ScaledClock, SteadyClock, TopicClock

_SAME_RATE = 1e-6


class ControlledFleet:
    """The nodes that control the robots of a process, and what they share.

    Attributes:
        robots: Numbers of the robots.
        time: Time of the current step.
        watch: Times the calls of scripts.
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
        self.process, self.node, self.warn = process, node, node.get_logger().warning
        self.parameters, self.options, self._safety = parameters, options, safety
        self._alone = alone
        law = parameters.options
        communication = communication.found(law.exercise)
        scripts = None if law.is_external else law.scripts()
        self._announced = FleetListener(node)
        self._nb_robots = options.nb_robots or self._found_fleet()
        self.robots = options.controlled(self._nb_robots)
        self._communication = chosen_communication(self._nb_robots, communication, law.seed)
        self.watch = CallWatch(self.warn, process.launcher)
        end_stuck_script(process, self.watch)
        drawing.canvas = MarkerCanvas(node)
        self._loader, laws = None, []
        if scripts:
            self._loader = self._law_loader(scripts)
            laws = self._loader.load()
            loaded = {one.path: one.names for one in laws}
            for text in doubts_at_start(loaded, self._communication, 1.0 / law.rate):
                self.warn(text)
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
            self.warn,
            self.watch,
            process.launcher,
            {one.robot: one.path for one in laws},
            self.robots,
            self._communication.condition_script or Path(CTC),
            Path(str(law.conversion())),
        )
        self._create_nodes(laws)
        self.parameters.on_change = self._follow
        nodes = [node, *itertools.chain(*self.phases, self.senders)]
        warn_of_unknown(nodes)
        self._watch_graph()
        process.requests = RequestWait(nodes, self._urgent)  # while they wait, too
        self._reloader = self._reload_on_save(laws)

    def _found_fleet(self) -> int:
        """Wait for the fleet; return its size, which is the given one if there is one."""
        given = self.options.nb_robots
        nb_robots = wait_for_fleet(self.process, self.node, self._announced, given)
        go_on(nb_robots)
        return max(nb_robots, self._alone.robot if self._alone else 0)  # it may come later

    def _clock_of_robots(self) -> SteadyClock:
        if self._announced.rtf != 1.0:
            return ScaledClock(self._announced.rtf, self._announced.begin)
        if not self.node.get_parameter(SIMULATED_TIME).value:
            return SteadyClock()
        clock = TopicClock(self.node)
        text = f'waiting for the time on {topics.CLOCK} ({SIMULATED_TIME}); is it published?'
        go_on(wait_until(self.process, clock.has_begun, lambda: self.warn(text)))
        return clock

    def _law_loader(self, scripts: LawScripts) -> LawLoader:
        scripts.check(self._nb_robots)
        task = TaskTopic(self.node, self._nb_robots)
        seed = self.parameters.options.seed
        return LawLoader(scripts, seed, self.robots, self._nb_robots, self.watch, task)

    def _create_nodes(self, laws: Sequence[ControlLaw]) -> None:
        law, safety, options = self.parameters.options, self._safety, self.options
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
        self.load_conditions()
        self.poses = self._subscribed_poses()
        for sender in self.senders:
            self.poses.listen(sender.robot, sender.evaluate)
        for si_to_uni in self.si_to_unis:
            si_to_uni.poses = self.poses
        self.network = FleetNetwork(self.node, self.poses, self._communication, self.robots)
        for controller, one in zip(self.controllers, laws, strict=True):
            controller.law, controller.network, controller.outcomes = (
                one,
                self.network,
                self.outcomes,
            )
        self.network.senders = {sender.robot: sender for sender in self.senders}
        self._models = DrivenModels(self.si_to_unis, self.warn)
        if options.model:
            self._models.use(model_names(options.model, self._nb_robots))
        else:
            self._models.follow(self._announced)
        filters = [self._safety_filter()] if safety.is_on and self.si_to_unis else []
        self.phases: list[Sequence[Any]] = [self.controllers, filters, self.si_to_unis]
        self.load_conversions()
        arena = None  # that of an experiment is the bridge's to show
        if safety.arena and not options.experiment:
            arena = Arena(*safety.arena)
        publish_obstacles(self.node, Obstacles.of(safety.obstacles or ''), arena)

    @property
    def _topic_of(self) -> Callable[[int], str]:
        """The topic with the poses of a robot that is not told another one."""
        return topics.mocap_topic if self.options.experiment else topics.odometry_topic

    def _subscribed_poses(self) -> FleetPoses:
        """Return the poses of all robots that the laws, their links or the filter need."""
        topic_of = self._topic_of
        sources: dict[int, tuple[FleetNode, str]] = {}
        needs_all = self.controllers and self._communication.needs_all_poses
        needs_all = needs_all or any(sender.broadcast.measures for sender in self.senders)
        if needs_all or (self._safety.is_on and self.si_to_unis):
            everyone = range(1, self._nb_robots + 1)
            sources = {robot: (self.node, topic_of(robot)) for robot in everyone}
        sources |= {one.robot: (one, one.odom_topic) for one in self.senders}
        sources |= {one.robot: (one, one.odom_topic) for one in self.si_to_unis}
        sources |= {one.robot: (one, one.odom_topic) for one in self.controllers}
        return FleetPoses(sources, self._nb_robots)

    def load_conversions(self) -> None:
        """Let robots be driven by the user's own si_to_uni, if there is one.

        Raises:
            SetcmasError: Its script does not load.
        """
        for si_to_uni, script in zip(self.si_to_unis, self._conversions(), strict=False):
            si_to_uni.convert_by(script)
        for safety_filter in self.phases[1]:
            safety_filter.convert_by(self._conversions())

    def _conversions(self) -> list[ScriptConversion]:
        """Return a user's own conversion for each robot, each with its own state, if any."""
        return script_conversions(
            self.parameters.options.conversion(),
            [one.robot for one in self.si_to_unis],
            self.outcomes.conversions,
            lambda: self.time.t,
            partial(self.watch.call, function=Function.SI_TO_UNI),
        )

    def load_conditions(self) -> None:
        """Let robots send their states when their conditions trigger."""
        path = self._communication.condition_script or Path(CTC)
        for sender in self.senders:
            sender.watch = self.watch
            with self.watch.loading(sender.robot, path):
                sender.broadcast = self._communication.broadcast(
                    sender.robot, self.outcomes.conditions
                )

    def _safety_filter(self) -> SafetyFilterNode:
        return SafetyFilterNode(
            self.node, self.si_to_unis, self._safety, self.parameters.options, self.poses
        )

    def _watch_graph(self) -> None:
        process, node, robots = self.process, self.node, self.si_to_unis
        is_of_one = self._alone is not None
        self.graph = GraphWatch(
            node, self.poses, self._topic_of, self._announced, robots, is_of_one
        )
        self._lost = LostRobots(self.robots, self.poses, self.warn)
        self._urgent: list[PolledTopic] = []
        if self.options.experiment:
            pause = PauseWatch(node, self.options.pause_timeout)
            self._is_paused: Callable[[], bool] = lambda: pause.reason() is not None
        else:
            fleet_pause = FleetPause(node, robots, process.launcher)
            self._urgent += fleet_pause.topics
            self._is_paused = lambda: fleet_pause.is_on
        self._run_time, self.time_topic = FleetTime(), None
        if len(self.robots) < self._nb_robots:  # other processes may control the others
            self.time_topic = FleetTimeTopic(
                node, self.robots, self._run_time, self.time.clock.now
            )
            self._urgent.append(self.time_topic.topic)
        self.note_step()

    def _reload_on_save(self, laws: Sequence[ControlLaw]) -> ScriptReloader | None:
        if not (self.options.watch and self._loader):
            return None
        return ScriptReloader(
            self.node,
            self,
            laws,
            self._loader,
            self._communication.condition_script if self.senders else None,
            self.parameters.options.conversion(),
            self.options.pause_timeout,
        )

    def poll(self) -> None:
        """Take messages between steps, and step nodes that follow other programs."""
        self.take()
        self.time.begin_step(self.time.clock.now())
        if self.controllers:  # velocities are those of the laws, in their steps
            for si_to_uni in self.si_to_unis:
                si_to_uni.repeat()
            return
        for phase in self.phases[1:]:
            for node in phase:
                node.step()

    def forget(self) -> None:
        """Drop velocities of other programs that have waited for the start."""
        for phase in self.phases[1:]:
            for node in phase:
                node.forget()

    @property
    def polls_often(self) -> bool:
        """Whether messages are taken between steps: states count when they come.

        Velocities of other programs cannot wait for a step, and slow commands are repeated.
        """
        return self.network.is_on or not self.controllers or self.time.period > REPEAT_S

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
        self.watch.begin_period()
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

    def note_step(self) -> None:
        """Note that odometry counts from now on: a step cannot receive any while it runs."""
        self._stepped = self.time.clock.now()

    def end_step(self) -> None:
        """Look after what is not urgent."""
        self.watch.end_period()
        if self.time_topic and self.controllers:
            self.time_topic.publish()
        self._stepped = self.time.now
        self.process.take_signals()  # scripts may have changed the handlers
        self.graph.check()
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
        for si_to_uni in self.si_to_unis:
            si_to_uni.cmd_vel.wait_until_sent()
        self.network.stop()

    def check(self, options: GainOptions) -> None:
        """Check that the rate of an experiment does not change.

        Raises:
            SetcmasError: It would change.
        """
        rate = 1.0 / self.time.period
        if self.options.experiment and abs(options.rate - rate) > _SAME_RATE:
            raise SetcmasError(
                f'rate is fixed at {rate:g} Hz during an experiment, because robots stop when '
                'commands are late; restart it with another --rate'
            )

    def _follow(self, options: GainOptions) -> None:
        """Let the nodes of all robots have these gains and this rate."""
        self.set_rate(options.rate)
        for phase in self.phases:
            for node in phase:
                if node is not self.node:
                    node.parameters.follow(options)

    def set_rate(self, rate: float) -> None:
        """Step at a rate in Hz from now on."""
        self.time.period = 1.0 / rate
        self.watch.slow.period = self.time.period / self.time.clock.rtf
        for phase in self.phases[1:]:  # the acceleration of robots depends on it
            for node in phase:
                node.expect(self.time.period)
