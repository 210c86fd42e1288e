"""The nodes that control the robots of a process, and what they share."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from setcmas_ctrl.controller import Controller
from setcmas_ctrl.controllers.fleet_monitor import FleetMonitor
from setcmas_ctrl.controllers.fleet_scripts import FleetScripts
from setcmas_ctrl.controllers.graph_watch import GraphWatch
from setcmas_ctrl.controllers.markers import publish_obstacles
from setcmas_ctrl.controllers.robot_models import DrivenModels
from setcmas_ctrl.controllers.script_reloader import ScriptReloader
from setcmas_ctrl.event_triggered_comm import EventTriggeredComm
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.fleet_network import FleetNetwork
from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_ctrl.laws.call_watch import CallWatch
from setcmas_ctrl.laws.control_options import ControllerOptions, GainOptions, LawOptions
from setcmas_ctrl.laws.si_to_uni_script import ScriptConversion
from setcmas_ctrl.safety_filter_node import SafetyFilterNode
from setcmas_ctrl.si_to_uni_node import REPEAT_S, SiToUni
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.robot_node import MOST_WITH_SERVICES, RobotNode, StepTime
from setcmas_simu.robots.model import limits_named
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.parameters import NodeParameters, warn_of_unknown
from setcmas_simu.ros.polling import RequestWait
from setcmas_simu.ros.process import FleetNode, RosProcess
from setcmas_simu.ros.step_loop import SteadyClock

_SAME_RATE = 1e-6


class Prepared(NamedTuple):
    """What there is of a fleet before the nodes of its robots.

    Attributes:
        announced: What simulators announce of it.
        nb_robots: Its size.
        clock: The clock of the robots.
        scripts: The loaded scripts of the robots of this process.
        alone: The only node, if the others of its robot are in other processes.
    """

    announced: FleetListener
    nb_robots: int
    clock: SteadyClock
    scripts: FleetScripts
    alone: RobotNode | None = None


class ControlledFleet:
    """The nodes that control the robots of a process, and what they share.

    Attributes:
        robots: Numbers of the robots.
        time: Time of the current step.
        scripts: The scripts of the robots.
        poses: Newest poses of the fleet.
        network: What the robots know of each other.
        controllers, si_to_unis: Nodes of the robots; no controllers without a law.
        senders: Their nodes that send states by events, if any.
        phases: All nodes that are stepped, in the order of the steps.
        monitor: Watches robots, pause, time and graph.
    """

    def __init__(
        self,
        process: RosProcess,
        node: FleetNode,
        parameters: NodeParameters[LawOptions],
        safety: FilterOptions,
        options: ControllerOptions,
        prepared: Prepared,
    ) -> None:
        """Create the nodes of the robots.

        Args:
            process: This process.
            node: Stands for the fleet: it has what there is once.
            parameters: Those of this node.
            safety: The safety filter.
            options: Which robots there are, and how they listen.
            prepared: What was found and loaded before.

        Raises:
            SetcmasError: A script does not load, or options contradict each other.
        """
        self.process, self.node, self.warn = process, node, node.get_logger().warning
        self.parameters, self.options, self._safety = parameters, options, safety
        self._announced, self._nb_robots, clock, self.scripts, self._alone = prepared
        self.robots = options.controlled(self._nb_robots)
        self.time = StepTime(1.0 / parameters.options.rate, clock)
        self._create_nodes()
        self._share()
        self.parameters.on_change = self._follow
        nodes = [node, *itertools.chain(*self.phases, self.senders)]
        warn_of_unknown(nodes)
        robots = self.si_to_unis
        is_of_one = self._alone is not None
        graph = GraphWatch(node, self.poses, self._topic_of, self._announced, robots, is_of_one)
        self.monitor = FleetMonitor(
            node,
            options,
            self.robots,
            self.poses,
            robots,
            graph,
            process.launcher,
            self.time,
        )
        process.requests = RequestWait(nodes, self.monitor.urgent)  # while they wait, too
        self._reloader = None
        if options.watch and self.scripts.laws:
            has_senders = bool(self.senders)
            self._reloader = ScriptReloader(
                node, self.scripts, has_senders, self.reload, options.pause_timeout
            )

    def _create_nodes(self) -> None:
        law, safety, options = self.parameters.options, self._safety, self.options
        limits = options.limits or limits_named(self._announced.limits)
        of_nodes: dict[str, Any] = {
            'fleet': self.node,
            'time': self.time,
            'has_services': len(self.robots) <= MOST_WITH_SERVICES,
        }
        nodes: list[RobotNode] = []
        if self._alone:
            self._alone.time = self.time
            nodes = [self._alone]
        for robot in self.robots if not nodes else ():
            if self.scripts.laws:
                nodes.append(Controller(robot, law, options.experiment, **of_nodes))
            nodes.append(SiToUni(robot, law, safety, options, limits, **of_nodes))
            if self.scripts.communication.event_triggered:
                nodes.append(EventTriggeredComm(robot, options.experiment, **of_nodes))
        self.controllers = [node for node in nodes if isinstance(node, Controller)]
        self.si_to_unis = [node for node in nodes if isinstance(node, SiToUni)]
        self.senders = [node for node in nodes if isinstance(node, EventTriggeredComm)]

    def _share(self) -> None:
        """Let the nodes have the scripts, the poses, and what robots know of each other."""
        options, safety = self.options, self._safety
        for sender in self.senders:
            sender.watch, sender.broadcast = self.watch, self.scripts.broadcast(sender.robot)
        self.poses = self._subscribed_poses()
        for sender in self.senders:
            self.poses.listen(sender.robot, sender.evaluate)
        for si_to_uni in self.si_to_unis:
            si_to_uni.poses = self.poses
        communication = self.scripts.communication
        senders = {sender.robot: sender for sender in self.senders}
        self.network = FleetNetwork(self.node, self.poses, communication, self.robots, senders)
        for controller, law in zip(self.controllers, self.scripts.laws, strict=True):
            controller.law, controller.network = law, self.network
            controller.outcomes = self.scripts.outcomes
        self._models = DrivenModels(self.si_to_unis, self.warn)
        if options.model:
            self._models.use(options.model, self._nb_robots)
        else:
            self._models.follow(self._announced)
        filters = [self._safety_filter()] if safety.is_on and self.si_to_unis else []
        self.phases: list[Sequence[Any]] = [self.controllers, filters, self.si_to_unis]
        self._load_conversions()
        publish_obstacles(self.node, safety, options.experiment)

    @property
    def watch(self) -> CallWatch:
        """Times the calls of scripts."""
        return self.scripts.watch

    @property
    def _topic_of(self) -> Callable[[int], str]:
        """The topic with the poses of a robot that is not told another one."""
        return topics.mocap_topic if self.options.experiment else topics.odometry_topic

    def _subscribed_poses(self) -> FleetPoses:
        """Return the poses of all robots that the laws, their links or the filter need."""
        topic_of = self._topic_of
        sources: dict[int, tuple[FleetNode, str]] = {}
        needs_all = self.controllers and self.scripts.communication.needs_all_poses
        needs_all = needs_all or any(sender.broadcast.measures for sender in self.senders)
        if needs_all or (self._safety.is_on and self.si_to_unis):
            everyone = range(1, self._nb_robots + 1)
            sources = {robot: (self.node, topic_of(robot)) for robot in everyone}
        own: tuple[Any, ...] = (*self.senders, *self.si_to_unis, *self.controllers)
        return FleetPoses(
            sources | {one.robot: (one, one.odom_topic) for one in own}, self._nb_robots
        )

    def _load_conversions(self) -> None:
        """Let robots be driven by the user's own si_to_uni, if any, or raise SetcmasError.

        The safety filter has its own copies.
        """
        robots = [one.robot for one in self.si_to_unis]

        def load() -> Sequence[ScriptConversion]:
            return self.scripts.conversions(robots, lambda: self.time.t)

        for si_to_uni, script in zip(self.si_to_unis, load(), strict=False):
            si_to_uni.convert_by(script)
        for safety_filter in self.phases[1]:
            safety_filter.convert_by(load())

    def _safety_filter(self) -> SafetyFilterNode:
        return SafetyFilterNode(
            self.node, self.si_to_unis, self._safety, self.parameters.options, self.poses
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
        self.time.t = self.monitor.run_time.at(now)
        self.network.take_values()
        self.poses.take(now)
        self.network.take()
        self._announced.take()
        if not self.options.model:
            self._models.follow(self._announced)

    def begin_step(self) -> None:
        """Take messages, and prepare the nodes for the step at the present time."""
        self.watch.begin_period()
        self.take()
        is_paused = self.monitor.begin_step()
        if not is_paused:
            self.network.begin_step(self.time.t)
        for controller in self.controllers:
            controller.is_paused = is_paused
            controller.is_lost = controller.robot in self.monitor.lost

    def end_step(self) -> None:
        """Look after what is not urgent."""
        self.watch.end_period()
        self.process.take_signals()  # scripts may have changed the handlers
        self.monitor.end_step(bool(self.controllers))
        if self._reloader:
            self._reloader.poll()

    def reload(self) -> str:
        """Load all scripts again, and reset t and errors; return what t is from now on.

        Raises:
            SetcmasError: One has a mistake; all robots stop.
        """
        is_shared = self.monitor.shares_t
        try:
            self.scripts.reload()
            for sender in self.senders:
                sender.broadcast = self.scripts.broadcast(sender.robot)
            self._load_conversions()
        except SetcmasError:
            self.scripts.laws = []
            raise
        finally:
            by_robot = {law.robot: law for law in self.scripts.laws}
            for controller in self.controllers:
                controller.law = by_robot.get(controller.robot)
            self.scripts.outcomes.begin_anew(loaded=bool(by_robot))
            self.monitor.run_time.begin_anew()
            self.network.forget_messages()
        return 't continues, as in other controllers' if is_shared else 't = 0'

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
