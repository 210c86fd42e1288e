"""The nodes that control the robots of a process, and what they share."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from setcmas_ctrl.controller import Controller
from setcmas_ctrl.controllers.fleet_monitor import FleetMonitor
from setcmas_ctrl.controllers.fleet_scripts import FleetScripts
from setcmas_ctrl.controllers.markers import publish_obstacles
from setcmas_ctrl.event_triggered_comm import EventTriggeredComm
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.fleet_network import FleetNetwork
from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_ctrl.laws.control_options import ControllerOptions, LawOptions
from setcmas_ctrl.safety_filter_node import SafetyFilterNode
from setcmas_ctrl.si_to_uni_node import REPEAT_S, SiToUni
from setcmas_ctrl.si_to_uni_script import ScriptConversion, script_conversions
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.robot_node import RobotNode, StepTime, with_services
from setcmas_simu.robots.model import limits_named
from setcmas_simu.robots.models_by_name import is_script, model_names, robot_models
from setcmas_simu.ros.clocks import SteadyClock
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.fleet_topic import Announcement, FleetListener
from setcmas_simu.ros.messages import wait_until_received
from setcmas_simu.ros.parameters import NodeParameters, warn_of_unknown
from setcmas_simu.ros.polling import RequestWait
from setcmas_simu.ros.process import RosProcess
from setcmas_simu.script_calls import Function


class ControlledFleet:
    """The nodes that control the robots of a process, and what they share.

    Attributes:
        robots: Numbers of the robots.
        time: Time of the current step.
        scripts: The scripts of the robots.
        poses: Newest poses of the fleet.
        network: What the robots know of each other.
        controllers: Nodes of the robots that call their laws; none without a law.
        senders: Their nodes that send states by events, if any.
        si_to_unis: Their nodes that command them.
        filters: The safety filter of the fleet, if there is one.
        followers: The nodes that follow velocities: the filter, and si_to_unis.
        nodes: All nodes that are stepped, in the order of the steps.
        monitor: Watches robots, pause, time and graph.
    """

    def __init__(
        self,
        process: RosProcess,
        node: FleetNode,
        parameters: NodeParameters[LawOptions],
        safety: FilterOptions,
        options: ControllerOptions,
        announced: FleetListener,
        scripts: FleetScripts,
        clock: SteadyClock,
    ) -> None:
        """Create the nodes of the robots.

        Args:
            process: This process.
            node: Node that stands for the fleet; or the only node of a robot here, if the other
                nodes that it needs are in other processes.
            parameters: Those of this node.
            safety: The safety filter.
            options: Which robots there are, and how they listen.
            announced: What simulators announce of the fleet.
            scripts: The loaded scripts of the robots of this process.
            clock: The clock of the robots.

        Raises:
            SetcmasError: A script does not load, or options contradict each other.
        """
        self.process, self.node, self.robots = process, node, scripts.robots
        self.parameters, self.options, self.scripts = parameters, options, scripts
        self._announced, self._followed = announced, parameters.options
        self.time = StepTime(1.0 / parameters.options.rate, clock)
        nodes = self._nodes(safety)
        self.controllers = [one for one in nodes if isinstance(one, Controller)]
        self.senders = [one for one in nodes if isinstance(one, EventTriggeredComm)]
        self.si_to_unis = [one for one in nodes if isinstance(one, SiToUni)]
        for sender in self.senders:
            sender.watch, sender.broadcast = scripts.watch, scripts.broadcast(sender.robot)
        self.poses = self._subscribed_poses(safety)
        self.network = FleetNetwork(node, self.poses, scripts.communication, self.robots)
        for controller, law in zip(self.controllers, scripts.laws, strict=True):
            controller.law, controller.network = law, self.network
            controller.watch = scripts.watch
            controller.reports = scripts.reports[Function.CONTROL]
        for si_to_uni in self.si_to_unis:
            si_to_uni.poses = self.poses
        self._taken: list[Announcement] = []
        self._refused_models: set[str] = set()
        if options.model:
            names = model_names(options.model, scripts.nb_robots)
            self._use_models({one.robot: names[one.robot - 1] for one in self.si_to_unis})
        self._follow_models()
        self.filters: list[SafetyFilterNode] = []
        if safety.is_on and self.si_to_unis:
            gains = parameters.options
            self.filters = [SafetyFilterNode(node, self.si_to_unis, safety, gains, self.poses)]
        self.load_conversions()
        publish_obstacles(node, safety, options.experiment)
        self.followers: list[Any] = [*self.filters, *self.si_to_unis]
        self.nodes = [*self.controllers, *self.followers]
        every_node: list[FleetNode] = [node, *self.nodes, *self.senders]
        warn_of_unknown(every_node)
        self.monitor = FleetMonitor(
            node, options, self.robots, self.poses, self.si_to_unis, process.launcher, self.time
        )
        urgent = [*self.monitor.urgent, *clock.topics]
        # Also while nodes wait.
        process.requests = RequestWait(every_node, urgent, with_services(nodes))

    def _nodes(self, safety: FilterOptions) -> list[RobotNode]:
        """Return the nodes of the robots in this process."""
        law, options = self.parameters.options, self.options
        if isinstance(self.node, RobotNode):
            self.node.time = self.time
            return [self.node]
        limits = options.limits or limits_named(self._announced.first.limits)
        of_nodes: dict[str, Any] = {'fleet': self.node, 'time': self.time}
        nodes: list[RobotNode] = []
        for robot in self.robots:
            if self.scripts.laws:
                nodes.append(Controller(robot, law, options.experiment, **of_nodes))
            nodes.append(SiToUni(robot, law, safety, options, limits, **of_nodes))
            if self.scripts.communication.event_triggered:
                nodes.append(EventTriggeredComm(robot, options.experiment, **of_nodes))
        return nodes

    def _subscribed_poses(self, safety: FilterOptions) -> FleetPoses:
        """Return the poses of all robots that the laws, their links or the filter need."""
        communication = self.scripts.communication
        sources: dict[int, tuple[FleetNode, str]] = {}
        if (
            (self.controllers and communication.needs_all_poses)
            or any(sender.broadcast.measures for sender in self.senders)
            or (safety.is_on and self.si_to_unis)
        ):
            topic_of = topics.mocap_topic if self.options.experiment else topics.odometry_topic
            everyone = range(1, self.scripts.nb_robots + 1)
            sources = {robot: (self.node, topic_of(robot)) for robot in everyone}
        own: tuple[Any, ...] = (*self.senders, *self.si_to_unis, *self.controllers)
        sources |= {one.robot: (one, one.odom_topic) for one in own}
        return FleetPoses(sources, self.scripts.nb_robots)

    def load_conversions(self) -> None:
        """Load the user's own si_to_uni for each robot, if there is one, or raise SetcmasError.

        The safety filter has its own copies.
        """
        for si_to_uni, script in zip(self.si_to_unis, self._conversions(), strict=False):
            si_to_uni.convert_by(script)
        for safety_filter in self.filters:
            safety_filter.convert_by(self._conversions())

    def _conversions(self) -> list[ScriptConversion]:
        return script_conversions(
            self.scripts.conversion,
            [one.robot for one in self.si_to_unis],
            self.scripts.reports[Function.SI_TO_UNI],
            lambda: self.time.t,
            partial(self.scripts.watch.call, function=Function.SI_TO_UNI),
        )

    def _follow_models(self) -> None:
        """Use the models of a new announcement, unless the user has chosen models."""
        announced = self._announced
        if self.options.model is not None or announced.announcements is self._taken:
            return
        self._taken, models = announced.announcements, announced.models
        for name in dict.fromkeys(models.values()):
            robots = [one.robot for one in self.si_to_unis if models.get(one.robot) == name]
            try:
                if is_script(name):
                    raise SetcmasError(f'if {name} defines command(), add --model {name}')
                self._use_models(dict.fromkeys(robots, name))
            except SetcmasError as error:
                if robots and name not in self._refused_models:
                    self._refused_models.add(name)
                    self.node.get_logger().warning(
                        f"{robots_in_words(robots)}: the simulator announces model '{name}', but "
                        f'si_to_uni drives them as unicycles: {error}'
                    )

    def _use_models(self, names: Mapping[int, str]) -> None:
        """Use models by robot, or raise SetcmasError if one is unknown or does not load."""
        warn = self.node.get_logger().warning
        models = robot_models([*names.values()], [*names], warn=warn)
        by_robot = dict(zip(names, models, strict=True))
        for si_to_uni in self.si_to_unis:
            if si_to_uni.robot in by_robot:
                si_to_uni.use(by_robot[si_to_uni.robot])

    def take(self) -> None:
        """Take pending messages: poses, states and messages that robots have sent."""
        now = self.time.clock.now()
        self.time.t = self.monitor.run_time.at(now)
        self.network.take_values()
        self.poses.take(now)
        for sender in self.senders:
            if state := self.poses.new.get(sender.robot):
                sender.evaluate(state, self.poses.odometry[sender.robot])
        self.network.take()
        self._announced.take()
        self._follow_models()

    def step(self) -> None:
        """Step all nodes: the laws, the filter, then si_to_uni, which gets what they publish."""
        self._begin_step()
        for node in self.nodes:
            node.step()
        self._end_step()

    def _begin_step(self) -> None:
        """Take messages, and prepare the nodes for the step at the present time."""
        if self.parameters.options is not self._followed:
            self.follow_parameters()
        self.scripts.watch.begin_period()
        self.take()
        self.monitor.begin_step()
        if not self.monitor.is_paused:
            self.network.begin_step(self.time.t)
            for sender in self.senders:
                known, adjacency = self.network.known_by(sender.robot)
                sender.see(known, self.poses.poses, adjacency)
        for controller in self.controllers:
            controller.is_paused = self.monitor.is_paused
            controller.is_lost = controller.robot in self.monitor.lost

    def _end_step(self) -> None:
        """Look after what is not urgent."""
        self.scripts.watch.end_period()
        self.process.take_signals()  # scripts may have changed the handlers
        self.monitor.end_step(bool(self.controllers))
        # Polled, because a state over a link counts when it comes, a velocity of another program
        # cannot wait for a step, and slow commands are repeated.
        is_slow = self.time.period > REPEAT_S
        self.time.is_polled = self.network.is_on or not self.controllers or is_slow

    def poll(self) -> None:
        """Take messages between steps, and step nodes that follow other programs."""
        self.take()
        self.time.begin_step(self.time.clock.now())
        if self.controllers:  # the laws give velocities, in their steps
            for si_to_uni in self.si_to_unis:
                si_to_uni.repeat()
        else:
            for follower in self.followers:
                follower.step()

    def follow_parameters(self) -> None:
        """Give the nodes of all robots the gains and the rate of the fleet's node."""
        options = self._followed = self.parameters.options
        self.time.period = 1.0 / options.rate
        self.scripts.watch.slow.period = self.time.period / self.time.clock.rtf
        for follower in self.followers:
            follower.expect(self.time.period)
        for node in self.nodes:
            if node is not self.node:
                node.parameters.follow(options)

    def stop(self) -> None:
        """Let every robot rest, its controller first."""
        for node in self.nodes:
            node.stop()
        wait_until_received(one.cmd_vel.publisher for one in self.si_to_unis)
        self.network.stop()
