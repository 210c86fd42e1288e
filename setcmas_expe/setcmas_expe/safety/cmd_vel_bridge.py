"""cmd_vel bridge of one robot: the only way from its controller to its wheels."""

from __future__ import annotations

import math

from geometry_msgs.msg import TwistStamped
from sensor_msgs.msg import BatteryState

from setcmas_expe.lab.model import Lab, LabRobot
from setcmas_expe.safety.decision import Decision
from setcmas_simu.cmd_vel.cmd_vel_publisher import CmdVelPublisher
from setcmas_simu.cmd_vel.cmd_vel_type import velocities
from setcmas_simu.fleet import topics
from setcmas_simu.messages.polled_topic import PolledTopic
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import FleetNode


class CmdVelBridge(FleetNode):
    """Keeps what a controller wants, and sends what was decided; SafetyStepper decides.

    Attributes:
        robot: Number of the robot.
        topic: Full name of the topic that the robot listens to.
        cmd_vel: Publishes to the robot.
        V: Forward speed that is wanted, in m/s.
        omega: Turn rate that is wanted, in rad/s.
        rival: Who else may move the robot, or move in its place; empty if nobody.
        battery: Charge in percent; None if the robot does not tell.
    """

    def __init__(self, robot: LabRobot, lab: Lab) -> None:
        """Create the node in the robot's namespace."""
        super().__init__(topics.CMD_VEL_BRIDGE_NODE, namespace=topics.robot_name(robot.number))
        self.robot = robot.number
        self.topic = robot.topic(topics.CMD_VEL)
        self.V = self.omega = 0.0
        self.rival = ''
        self.battery: float | None = None
        self._received = self._comes_from = -math.inf
        self._wanted = topics.robot_topic(robot.number, topics.CMD_VEL_WANTED)
        self.cmd_vel = CmdVelPublisher(
            self,
            robot.number,
            self.topic,
            robot.topic(topics.ODOM),
            lab.cmd_vel_type,
            qos.ROBOT_COMMAND,
        )
        self._commands = PolledTopic(
            self, TwistStamped, self._wanted, self._on_wanted, qos.COMMAND
        )
        self.create_subscription(
            BatteryState, robot.topic(topics.BATTERY), self._on_battery, qos.SENSOR
        )

    def take(self, last: float) -> None:
        """Take the newest command of the controller.

        Args:
            last: When commands were taken last, in s: it counts as old as it can be.
        """
        self._comes_from = last
        self._commands.take()

    def age(self, now: float) -> float:
        """Return how old the last command of the controller is, in s; inf before the first."""
        return now - self._received

    def look_around(self) -> None:
        """See who else commands the robot, or is taken for it."""
        controllers = self.count_publishers(self._wanted)
        several = f'{controllers} controllers want to move it' if controllers > 1 else ''
        self.rival = self.cmd_vel.rival() or several

    def send(self, decision: Decision) -> None:
        """Command the robot."""
        self.cmd_vel.publish(decision.V, decision.omega)

    def _on_wanted(self, message: TwistStamped) -> None:
        self.V, self.omega = velocities(message)
        self._received = self._comes_from

    def _on_battery(self, message: BatteryState) -> None:
        percentage = message.percentage
        self.battery = float(percentage) if math.isfinite(percentage) else None
