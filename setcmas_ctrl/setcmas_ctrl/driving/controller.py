"""Controller node: publishes what one robot's control law wants."""

from __future__ import annotations

from geometry_msgs.msg import Point32
from rclpy.publisher import Publisher
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
        self._allowed: Publisher | None = None
        self._message = Point32()

    def tell_allowed(self, profile: QoSProfile) -> None:
        """Have a topic for what the safety filter lets through."""
        topic = topics.CMD_CART_VEL_ALLOWED
        self._allowed = self.create_publisher(Point32, topic, profile)

    def publish_allowed(self, vx: float, vy: float, verdict: float) -> None:
        """Publish what the safety filter lets through, in m/s, and its verdict."""
        if self._allowed:
            self._allowed.publish(Point32(x=vx, y=vy, z=verdict))

    def publish(self, vx: float, vy: float) -> None:
        """Publish a velocity (m/s) in the world frame."""
        self._message.x, self._message.y = vx, vy
        self._publisher.publish(self._message)
