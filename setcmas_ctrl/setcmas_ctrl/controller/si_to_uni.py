"""Node si_to_uni: a wanted velocity (cmd_cart_vel) in, a robot's command (cmd_vel) out."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import Point32
from std_msgs.msg import Bool

from setcmas_ctrl.fleet.odometry import FleetOdometry
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.topics import AUTO
from setcmas_simu.robots.model import RobotModel
from setcmas_simu.robots.unicycle import UNICYCLE
from setcmas_simu.ros import qos
from setcmas_simu.ros.cmd_vel_publisher import CmdVelPublisher
from setcmas_simu.ros.process import FleetNode

NODE_NAME = 'si_to_uni'


class SiToUni(FleetNode):
    """Commands one robot; zero while it is paused, and when the process ends.

    Attributes:
        robot: Number of the robot.
        paused: Whether it is held at zero.
        model: How it turns velocities into commands.
    """

    def __init__(
        self,
        robot: int,
        odometry: FleetOdometry,
        komega: float,
        cmd_vel_type: str = AUTO,
        topic: str = topics.CMD_VEL,
    ) -> None:
        """Create the node in the robot's namespace.

        Args:
            robot: Number of the robot.
            odometry: Where its heading is read.
            komega: Gain on the heading error in 1/s.
            cmd_vel_type: 'twist', 'twist_stamped', or 'auto' for what the robot listens to.
            topic: Name of the robot's topic that takes the commands.
        """
        super().__init__(NODE_NAME, namespace=topics.robot_name(robot))
        self.robot = robot
        self.paused = False
        self.model: RobotModel = UNICYCLE
        self._odometry = odometry
        self._komega = komega
        self.cmd_vel = CmdVelPublisher(
            self,
            robot,
            topics.robot_topic(robot, topic),
            topics.odometry_topic(robot),
            cmd_vel_type,
        )
        self.create_subscription(
            Point32, topics.CMD_CART_VEL, self._on_wanted_velocity, qos.COMMAND
        )
        self.create_subscription(
            Bool, topics.PAUSE, lambda message: self.pause(message.data), qos.EVENT
        )

    def pause(self, paused: bool) -> None:
        """Hold the robot at zero velocity, or let it go on."""
        self.paused = paused
        if paused:
            self.cmd_vel.publish(0.0, 0.0)

    def stop(self) -> None:
        """Command zero; called while the process ends."""
        self.cmd_vel.publish(0.0, 0.0)

    def _on_wanted_velocity(self, message: Point32) -> None:
        if self.paused:
            self.cmd_vel.publish(0.0, 0.0)
            return
        velocity = np.array([[message.x], [message.y]], dtype=float)
        pose = self._odometry.pose(self.robot)
        V, left, omega = self.model.command(velocity, pose, self._komega)[:, 0].tolist()
        self.cmd_vel.publish(V, omega, left)
