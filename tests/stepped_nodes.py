"""The nodes of a run, stepped in one process with all data over topics; offline runs equal it."""

import contextlib
import os

import numpy as np
import rclpy
from stepped_alone import SetClock

from setcmas_ctrl import network
from setcmas_ctrl.controllers.controller_processes import PARAMETERS, prepared_fleet
from setcmas_ctrl.laws.control_options import ControllerOptions
from setcmas_ctrl.laws.script_seeds import seeded_generators
from setcmas_simu import simulator
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import through_quaternion
from setcmas_simu.reports import connected_launcher
from setcmas_simu.robots.model import limits_named
from setcmas_simu.robots.models_by_name import NO_LIMITS
from setcmas_simu.ros.dds_setup import dds_setup
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.fleet_topic import FleetAnnouncer
from setcmas_simu.ros.parameters import NodeParameters
from setcmas_simu.ros.process import RosProcess
from setcmas_simu.simulation_options import SimulationOptions
from setcmas_tools.offline.offline_simulation import _calls


class SteppedRun:
    """The nodes of a scenario: virtual_robot, controller, si_to_uni, and what else it has.

    Attributes:
        poses: Poses of the robots after each step, as messages carry them, shape (K + 1, 3, N).
        sent: Whether each robot sent its state at a step, shape (K + 1, N), if by events.
    """

    def __init__(self, scenario) -> None:
        self.scenario = scenario
        self._clock = SetClock()
        self._process = RosProcess(connected_launcher({}))
        options = SimulationOptions.among(scenario.values())
        node = FleetNode(topics.VIRTUAL_ROBOTS)
        parameters = simulator.fleet_parameters(node, options)
        self.robots = simulator.virtual_robots(node, options)
        self._simulator = simulator.Simulator(node, self.robots, parameters)
        self._simulator.time.clock = self._clock
        FleetAnnouncer(node).announce(self._simulator.announcement)
        law = scenario.law
        node = FleetNode(topics.CONTROLLERS, follows_clock=True)
        limits = options.limits
        self.fleet = prepared_fleet(
            self._process,
            node,
            NodeParameters(node, law, PARAMETERS),
            scenario.communication,
            scenario.safety,
            ControllerOptions(
                nb_robots=scenario.nb_robots,
                model=options.model,
                limits=limits_named(limits) if limits != NO_LIMITS else None,
            ),
            clock=self._clock,
        )

    def run(self) -> 'SteppedRun':
        """Step the nodes for the duration of the scenario."""
        rate = self.scenario.robots.robot_rate
        t = np.arange(self.scenario.robots.nb_steps(self.scenario.time.duration) + 1) / rate
        control_t, due = _calls(t, 1.0 / rate, self.scenario.law.rate)
        calls = list(zip(control_t.tolist(), due, strict=True))
        poses, sent = [], []
        with network.exchanged_by(self.fleet.network):
            self._until_connected()
            for step, now in enumerate(t.tolist()):
                self._clock.t = now
                before = [sender.sent for sender in self.fleet.senders]
                self._simulator.time.begin_step(now)
                for robot in self.robots:
                    robot.step()
                self.fleet.poll()  # si_to_uni repeats commands between the laws' calls
                poses.append([robot.state[:3, 0] for robot in self.robots])
                pairs = zip(self.fleet.senders, before, strict=True)
                sent.append([sender.sent is not last for sender, last in pairs])
                while calls and calls[0][1] <= step:
                    self._clock.t = calls.pop(0)[0]
                    self.fleet.time.begin_step(self._clock.t)
                    self.fleet.step()
        through = through_quaternion(np.array(poses).transpose(2, 0, 1))
        self.poses, self.sent = through.transpose(1, 0, 2), np.array(sent)
        return self

    def _until_connected(self) -> None:
        robots = self.fleet.si_to_unis
        self._process.spin_until(
            lambda: all(robot.cmd_vel.follow_listeners() for robot in robots), 10.0
        )


@contextlib.contextmanager
def stepped_nodes(scenario, domain: int):
    """Yield the stepped nodes of a scenario in a ROS domain."""
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    with dds_setup():
        rclpy.init(domain_id=domain)
    try:
        with seeded_generators():
            yield SteppedRun(scenario)
    finally:
        rclpy.shutdown()
