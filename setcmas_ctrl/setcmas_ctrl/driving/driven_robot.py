"""Topics of a driven robot: the velocity of its law, and its commands (si_to_uni)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from geometry_msgs.msg import Point32
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Bool

from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.topics import AUTO
from setcmas_simu.robots.model import RobotModel
from setcmas_simu.robots.models import is_script, robot_models
from setcmas_simu.robots.unicycle import UNICYCLE
from setcmas_simu.ros import qos
from setcmas_simu.ros.cmd_vel_topics import CmdVelPublisher
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.polling import OnDemandPublisher, PolledTopic

_Numbers = tuple[float, float, float]
_NONE: _Numbers = (math.nan, math.nan, math.nan)


def _profile(in_lockstep: bool) -> QoSProfile:
    return qos.LOCKSTEP_COMMAND if in_lockstep else qos.COMMAND


class Controller:
    """Publishes the velocity of one robot's control law, and that after the safety filter.

    Attributes:
        wanted: The last velocity of its law in m/s, and 0; NaN before the first.
        allowed: The last velocity after the filter in m/s, and its verdict; NaN before the first.
    """

    def __init__(
        self,
        node: Node,
        law: ControlLaw,
        in_lockstep: bool = False,
        filtered: bool = False,
    ) -> None:
        """Create the topics of a robot's law; in lockstep they are published on demand."""
        profile = _profile(in_lockstep)
        self.law = law
        self.robot = law.robot
        topic = partial(topics.robot_topic, law.robot)
        self.wanted = self.allowed = _NONE
        self._publisher = OnDemandPublisher(
            node.create_publisher(Point32, topic(topics.CMD_CART_VEL), profile)
        )
        self._allowed: OnDemandPublisher | None = None
        if filtered:
            self._allowed = OnDemandPublisher(
                node.create_publisher(Point32, topic(topics.CMD_CART_VEL_ALLOWED), profile)
            )

    def publish_allowed(self, vx: float, vy: float, verdict: float) -> None:
        """Publish the velocity after the safety filter, in m/s, and the filter's verdict."""
        self.allowed = vx, vy, verdict
        if self._allowed:
            self._allowed.publish(lambda: Point32(x=vx, y=vy, z=verdict))

    def publish(self, vx: float, vy: float) -> None:
        """Publish a velocity (m/s) in the world frame."""
        self.wanted = vx, vy, 0.0
        self._publisher.publish(lambda: Point32(x=vx, y=vy))


class SiToUni:
    """Commands one robot; zero while it is paused and when the process ends.

    Attributes:
        sent: The last command: speeds forward and left in m/s, turn rate in rad/s; NaN before.
    """

    def __init__(
        self,
        node: Node,
        robot: int,
        cmd_vel_type: str = AUTO,
        topic: str = topics.CMD_VEL,
        in_lockstep: bool = False,
    ) -> None:
        """Create the topics of a robot on the node of its process.

        The type of cmd_vel is 'twist', 'twist_stamped', or 'auto' for the type of its listener. In
        lockstep it is published on demand: the simulator takes commands from answers.
        """
        self.robot = robot
        self.paused = self.stopped = False
        self.sent = _NONE
        self.model: RobotModel = UNICYCLE
        self.cmd_vel = CmdVelPublisher(
            node,
            robot,
            topics.robot_topic(robot, topic),
            topics.odometry_topic(robot),
            cmd_vel_type,
            _profile(in_lockstep),
            always=not in_lockstep,
        )
        pause = topics.robot_topic(robot, topics.PAUSE)
        self._pauses = PolledTopic(
            node, Bool, pause, lambda message: self.pause(message.data), qos.EVENT
        )

    def take(self) -> None:
        """Take pending pause requests."""
        self._pauses.take()

    def pause(self, paused: bool) -> None:
        """Pause or resume the robot."""
        self.paused = paused or self.stopped
        if self.paused:
            self.stop()

    def stop(self) -> None:
        """Command zero."""
        self._send(0.0, 0.0, 0.0)

    def command(self, V: float, left: float, omega: float) -> None:
        """Command speeds forward and to the left (m/s) and a turn rate (rad/s), unless paused."""
        if self.paused:
            self.stop()
        else:
            self._send(V, left, omega)

    def _send(self, V: float, left: float, omega: float) -> None:
        self.sent = V, left, omega
        self.cmd_vel.publish(V, omega, left)


class DrivenModels:
    """Sets the models of driven robots."""

    def __init__(self, drivers: Sequence[SiToUni], warn: Callable[[str], None]) -> None:
        self._drivers = {driver.robot: driver for driver in drivers}
        self._warn = warn
        self._reported: set[str] = set()

    def use(self, names: Sequence[str]) -> None:
        """Use these models, one name for each robot of the fleet.

        Raises:
            SetcmasError: A model is unknown, or a script does not load.
        """
        robots = list(self._drivers)
        self._set(robots, [names[robot - 1] for robot in robots])

    def follow(self, announced: FleetListener) -> None:
        """Use the announced models, now and after each new announcement."""
        announced.on_change = lambda: self._take(announced.models)
        self._take(announced.models)

    def _take(self, models: Mapping[int, str]) -> None:
        for name in dict.fromkeys(models.values()):
            robots = [robot for robot in self._drivers if models.get(robot) == name]
            try:
                if is_script(name):
                    raise SetcmasError(f'if {name} defines command(), add --model {name}')
                self._set(robots, [name] * len(robots))
            except SetcmasError as error:
                self._report(name, robots, error)

    def _set(self, robots: list[int], names: list[str]) -> None:
        models = robot_models(names, robots, warn=self._warn)
        for robot, model in zip(robots, models, strict=True):
            self._drivers[robot].model = model

    def _report(self, name: str, robots: list[int], error: SetcmasError) -> None:
        if robots and name not in self._reported:
            self._reported.add(name)
            self._warn(
                f'{robots_in_words(sorted(robots))}: the simulator '
                f"announces model '{name}'; driven as unicycles: {error}"
            )
