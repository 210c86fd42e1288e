"""Controller node: publishes what one robot's control law wants."""

from __future__ import annotations

from geometry_msgs.msg import Point32
from rclpy.qos import QoSProfile

from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import FleetNode


class Controller(FleetNode):
    """Publishes the velocity that one robot's control law wants."""

    def __init__(self, law: ControlLaw, profile: QoSProfile = qos.COMMAND) -> None:
        """Create the node in the robot's namespace."""
        super().__init__('controller', namespace=topics.robot_name(law.robot))
        self.law = law
        self.robot = law.robot
        self._publisher = self.create_publisher(Point32, topics.CMD_CART_VEL, profile)
        self._message = Point32()

    def publish(self, vx: float, vy: float) -> None:
        """Publish a velocity (m/s) in the world frame."""
        self._message.x, self._message.y = vx, vy
        self._publisher.publish(self._message)
