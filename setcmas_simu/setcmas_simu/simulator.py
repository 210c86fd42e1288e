"""The simulator process: the virtual robots of a fleet.

Start it with `ros2 run setcmas_simu virtual_robot --nb-robots 8`, for a part of them with
`--robots 1-4`. Without these options it has one robot, which ROS's names and parameters describe:
`--ros-args -r __ns:=/tb3_3 -p x0:=1.0 -p limits:=burger`.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence

from rosgraph_msgs.msg import Clock
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.reports import Failed
from setcmas_simu.robot_node import StepTime, run_steps, with_services
from setcmas_simu.robots.models_by_name import check_models, model_names, seed_scripts
from setcmas_simu.ros import qos
from setcmas_simu.ros.clocks import ScaledClock
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.fleet_topic import Announcement, FleetAnnouncer
from setcmas_simu.ros.parameters import NodeParameters, warn_of_unknown
from setcmas_simu.ros.polling import RequestWait
from setcmas_simu.ros.process import RosProcess, end_process, node_main
from setcmas_simu.ros.simulator_watch import SimulatorWatch, refuse_second_simulator
from setcmas_simu.simulation_options import SimulationOptions
from setcmas_simu.virtual_robot import VirtualRobot

PARAMETERS = {'rate': 'robot_rate', 'limits': 'limits', 'cmd_timeout': 'cmd_timeout'}
"""The options that are parameters of the node of the process, by parameter name."""


def main(argv: list[str] | None = None) -> int:
    """Simulate robots until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='virtual_robot', description=__doc__)
    SimulationOptions.add_to(parser)
    return node_main(parser, _simulate, argv)


def _simulate(process: RosProcess, args: argparse.Namespace) -> None:
    options = SimulationOptions.of(args)
    on_failure = process.launcher.report

    def is_stopping() -> bool:
        return process.stopping

    node: FleetNode
    if options.robots is None and options.nb_robots is None:
        simulated = options.simulated()
        start = tuple(simulated.start_poses[:, 0].tolist())
        node = robot = VirtualRobot(None, start, simulated.models[0], options, on_failure)
        robots = [robot]
        parameters = NodeParameters(node, options, {'rate': 'robot_rate'})
        refuse_second_simulator(node, [robot.robot], nb_own=1, is_stopping=is_stopping)
        announcer = FleetAnnouncer(node)
    else:
        node = FleetNode(topics.VIRTUAL_ROBOTS, enable_rosout=True)
        parameters = fleet_parameters(node, options)
        options = parameters.options
        refuse_second_simulator(node, options.simulated().robots, is_stopping=is_stopping)
        # First: whoever discovers the topics of the robots has then found it.
        announcer = FleetAnnouncer(node)
        robots = virtual_robots(node, options, on_failure)
    warn_of_unknown([node, *robots])
    simulator = Simulator(node, robots, parameters)
    announcer.announce(simulator.announcement)
    process.launcher.report_ready()
    simulator.run(process)


def fleet_parameters(
    node: FleetNode, options: SimulationOptions
) -> NodeParameters[SimulationOptions]:
    """Declare the parameters of the fleet's node; its limits must suit all models."""
    models = model_names(options.model, options.fleet_size)
    return NodeParameters(
        node, options, PARAMETERS, check=lambda changed: check_models(models, changed.limits)
    )


def virtual_robots(
    node: FleetNode,
    options: SimulationOptions,
    on_failure: Callable[[Failed], object] = bool,
) -> list[VirtualRobot]:
    """Return the robots that options ask for, in the process and namespace of a node.

    Raises:
        SetcmasError: An option is invalid, or a model does not load.
    """
    simulated = options.simulated()
    seed_scripts(simulated.models, options.seed)
    return [
        VirtualRobot(robot, tuple(start), model, options, on_failure, fleet=node)
        for robot, start, model in zip(
            simulated.robots, simulated.start_poses.T.tolist(), simulated.models, strict=True
        )
    ]


class Simulator:
    """Steps the virtual robots of a process, and does what is to be done once for all."""

    def __init__(
        self,
        node: FleetNode,
        robots: Sequence[VirtualRobot],
        parameters: NodeParameters[SimulationOptions],
    ) -> None:
        """Prepare; `node`, maybe the only robot, stands for the fleet and has its parameters."""
        options = parameters.options
        clock = None if options.rtf == 1.0 else ScaledClock(options.rtf)
        self.time = StepTime(1.0 / options.robot_rate, clock)
        self._node = node
        self._robots = robots
        self._parameters, self._options = parameters, options
        for robot in robots:
            robot.time = self.time
        node.create_service(Trigger, '~/reset', self._answer_reset)
        self._reset = node.newest(Empty, topics.FLEET_RESET, qos.EVENT)
        self._clock = None
        if clock:
            self._clock = node.create_publisher(Clock, topics.CLOCK, qos.STATE)
        numbers = [robot.robot for robot in robots]
        self._watch = SimulatorWatch(node, numbers, options.cmd_vel_type)
        self.announcement = Announcement(
            max(options.fleet_size, *numbers),
            tuple(numbers),
            tuple(robot.model_name for robot in robots),
            options.limits,
            options.rtf,
            clock.begin if clock else 0.0,
        )

    def run(self, process: RosProcess) -> None:
        """Step until the process must stop."""
        robots = robots_in_words([robot.robot for robot in self._robots])
        rate = 1.0 / self.time.period
        self._node.get_logger().info(f'simulating {robots} at {rate:g} Hz; Ctrl-C stops')
        nodes = [self._node, *self._robots]
        process.requests = RequestWait(nodes, late=with_services(self._robots))
        run_steps(process, self.time, self.step)

    def step(self) -> None:
        """Step all robots; before, apply what has changed, and publish the time if it is ours."""
        if self._parameters.options is not self._options:
            self._follow(self._parameters.options)
        if self._clock:
            self._clock.publish(Clock(clock=self.time.stamp))
        if self._reset():
            self._restart()
        for robot in self._robots:
            robot.step()
        self._watch.end_step(self.time.now, self.time.period)

    def _follow(self, options: SimulationOptions) -> None:
        """Let all robots have new options of the fleet."""
        self._options = options
        self.time.period = 1.0 / options.robot_rate
        for robot in self._robots:
            if robot is not self._node:
                robot.parameters.follow(options)

    def _restart(self) -> None:
        for robot in self._robots:
            robot.restart()

    def _answer_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._restart()
        response.success, response.message = True, 'all robots are back at their start poses'
        return response


if __name__ == '__main__':
    end_process(main())
