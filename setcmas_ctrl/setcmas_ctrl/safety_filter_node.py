"""The safety filter: a node that changes the velocities of a fleet as little as is safe."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from geometry_msgs.msg import Point32

from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_ctrl.laws.control_options import GainOptions
from setcmas_ctrl.safety_filter import SafetyFilter
from setcmas_ctrl.saturation import saturate
from setcmas_ctrl.si_to_uni import Conversion
from setcmas_ctrl.si_to_uni_node import RESTS_S, SiToUni
from setcmas_ctrl.velocity_conversion import VelocityConversion
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_node import FleetNode, of_other_nodes
from setcmas_simu.ros.parameters import NodeParameters

_ROUNDED = 1.0 + 1e-6  # velocities come in single precision


class SafetyFilterNode(FleetNode):
    """Keeps robots apart: cmd_cart_vel of each robot in, cmd_cart_vel_allowed out.

    z of cmd_cart_vel_allowed is the `Verdict`.

    Attributes:
        robots: The nodes of the robots, which follow what it allows.
        wanted: For each of them a function that returns the newest velocity, or None.
        allowed: The publishers of the velocities that are allowed.
        velocities: The velocities wanted last, rows vx, vy in m/s, shape (2, N).
        received_at: When they came, in s, shape (N,).
    """

    def __init__(
        self,
        fleet: FleetNode,
        robots: Sequence[SiToUni],
        options: FilterOptions,
        gains: GainOptions,
        poses: FleetPoses,
    ) -> None:
        """Filter the velocities of all robots of a fleet.

        Raises:
            SetcmasError: The filter cannot guarantee safety for these robots.
        """
        nb_robots = poses.poses.shape[1]
        of_fleet = {'namespace': fleet.fleet_namespace or '/', 'context': fleet.context}
        super().__init__('safety_filter', True, **of_fleet, **of_other_nodes())
        self.parameters = NodeParameters(self, gains, ('vnom', 'komega'))
        self.robots, self.poses = robots, poses
        self.time = robots[0].time
        accel = options.accel or math.inf
        self.conversion = VelocityConversion(nb_robots, gains.komega, 1.0 / gains.rate, accel)
        self.filter = SafetyFilter(options, nb_robots, self.conversion, self.get_logger().warning)
        self.models: list[Any] = []
        self.wanted: list[Callable[[], Any]] = []
        self.allowed = []
        for robot in range(1, nb_robots + 1):
            source = self.full_name(topics.robot_topic(robot, topics.CMD_CART_VEL))
            target = topics.robot_topic(robot, topics.CMD_CART_VEL_ALLOWED)
            self.wanted.append(self.newest(Point32, source, qos.COMMAND))
            self.allowed.append(self.create_publisher(Point32, target, qos.COMMAND))
        self.velocities = np.zeros((2, nb_robots))
        self.received_at = np.full(nb_robots, -math.inf)

    def convert_by(self, scripts: Sequence[Conversion]) -> None:
        """Expect that the robots convert velocities by a user's own scripts, if there are any."""
        self.conversion.scripts = scripts
        self.models = []  # they are set with the next step

    def expect(self, period: float) -> None:
        """Expect velocities every so many s from now on."""
        self.conversion.Ts = period

    def forget(self) -> None:
        """Drop velocities that have waited for the start."""
        for wanted in self.wanted:
            wanted()

    def step(self) -> None:
        """Publish what the robots may do, if a new velocity has come; z has the verdict."""
        now = self.time.now
        for i, wanted in enumerate(self.wanted):
            if message := wanted():
                self.velocities[:, i] = message.x, message.y
                self.received_at[i] = now
        if not (self.received_at == now).any():
            return
        robot, silent_for = self.robots[0], now - self.received_at
        rests = silent_for > robot.timeout
        # Silence reaches si_to_uni, too: in an experiment at once, else after a second of rest.
        speaks = silent_for <= (0.0 if robot.in_experiment else robot.timeout + RESTS_S)
        if self.models != (models := [robot.model for robot in self.robots]):
            self.models = models
            self.filter.use(models)
        self.velocities[:, rests] = 0.0
        has_failed = ~np.isfinite(self.velocities).all(axis=0)  # NaN: laws in experiments
        gains = self.parameters.options
        velocities = np.where(has_failed, 0.0, self.velocities)
        is_fast = np.hypot(*velocities) > gains.vnom * _ROUNDED  # not those of controllers
        velocities[:, is_fast] = saturate(velocities[:, is_fast], gains.vnom)
        self.conversion.komega = gains.komega
        allowed, verdicts = self.filter(velocities, self.poses.poses, gains.vnom)
        allowed = np.where(has_failed, math.nan, allowed)
        for i in np.flatnonzero(speaks).tolist():
            vx, vy = allowed[:, i].tolist()
            self.allowed[i].publish(Point32(x=vx, y=vy, z=float(verdicts[i])))

    def stop(self) -> None:
        """Let the robots rest."""
        for publisher in self.allowed:
            publisher.publish(Point32())
