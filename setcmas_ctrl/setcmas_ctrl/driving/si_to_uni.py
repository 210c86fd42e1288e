"""Node si_to_uni: the commands of one robot (cmd_vel)."""

from __future__ import annotations

from rclpy.qos import QoSProfile
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from setcmas_simu.cmd_vel.cmd_vel_publisher import CmdVelPublisher
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.topics import AUTO
from setcmas_simu.messages.polled_service import PolledService
from setcmas_simu.messages.polled_topic import PolledTopic
from setcmas_simu.robots.model import RobotModel
from setcmas_simu.robots.unicycle import UNICYCLE
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import FleetNode

NODE_NAME = 'si_to_uni'


class SiToUni(FleetNode):
    """Commands one robot; zero while it is paused, and when the process ends.

    Attributes:
        robot: Number of the robot.
        paused: Whether it is held at zero.
        stopped: Whether it stays so: an emergency stop.
        model: How it turns velocities into commands.
    """

    def __init__(
        self,
        robot: int,
        cmd_vel_type: str = AUTO,
        topic: str = topics.CMD_VEL,
        profile: QoSProfile = qos.COMMAND,
    ) -> None:
        """Create the node in the robot's namespace.

        Args:
            robot: Number of the robot.
            cmd_vel_type: 'twist', 'twist_stamped', or 'auto' for what the robot listens to.
            topic: Name of the robot's topic that takes the commands.
            profile: Quality of service of the commands.
        """
        super().__init__(NODE_NAME, namespace=topics.robot_name(robot))
        self.robot = robot
        self.paused = self.stopped = False
        self.model: RobotModel = UNICYCLE
        self.cmd_vel = CmdVelPublisher(
            self,
            robot,
            topics.robot_topic(robot, topic),
            topics.odometry_topic(robot),
            cmd_vel_type,
            profile,
        )
        self._pauses = PolledTopic(
            self, Bool, topics.PAUSE, lambda message: self.pause(message.data), qos.EVENT
        )
        self._offered: list[PolledService] = []

    def offer_services(self) -> None:
        """Offer `~/pause`, which does what the topic does, and says so."""
        self._offered.append(PolledService(self, SetBool, '~/pause', self._answer_pause))

    def take(self) -> None:
        """Take the wishes to pause the robot that have come."""
        self._pauses.take()
        for service in self._offered:
            service.take()

    def pause(self, paused: bool) -> None:
        """Hold the robot at zero velocity, or let it go on."""
        self.paused = paused or self.stopped
        if self.paused:
            self.cmd_vel.publish(0.0, 0.0)

    def _answer_pause(
        self, request: SetBool.Request, response: SetBool.Response
    ) -> SetBool.Response:
        self.pause(request.data)
        name = topics.robot_name(self.robot)
        response.success = True
        response.message = f'{name} is paused' if request.data else f'{name} is not paused itself'
        return response

    def stop(self) -> None:
        """Command zero."""
        self.cmd_vel.publish(0.0, 0.0)

    def command(self, V: float, left: float, omega: float) -> None:
        """Command speeds forward and to the left (m/s) and a turn rate (rad/s), unless paused."""
        if self.paused:
            self.stop()
        else:
            self.cmd_vel.publish(V, omega, left)
