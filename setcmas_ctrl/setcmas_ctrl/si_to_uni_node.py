"""si_to_uni: a node that converts the velocity that a robot should have to its command.

Whoever publishes cmd_cart_vel drives the robot: a controller of `setcmas ctrl`, or a program in
any language. `setcmas ctrl` runs the nodes of a whole fleet in one process
(`controllers/controlled_fleet.py`). To run one alone:

    ros2 run setcmas_ctrl si_to_uni --ros-args -r __ns:=/tb3_3 -p komega:=2.0
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from geometry_msgs.msg import Point32
from std_msgs.msg import Bool

from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.fleet_poses import POSE_TIMEOUT_S, FleetPoses
from setcmas_ctrl.laws.control_options import ControllerOptions, GainOptions
from setcmas_ctrl.si_to_uni import Conversion
from setcmas_ctrl.velocity_conversion import VelocityConversion
from setcmas_simu.fleet import topics
from setcmas_simu.robot_node import RobotNode
from setcmas_simu.robots.model import IDEAL, RobotModel, VelocityLimits
from setcmas_simu.robots.unicycle import UNICYCLE, Unicycle
from setcmas_simu.ros import qos
from setcmas_simu.ros.cmd_vel_topics import CmdVelPublisher, Command
from setcmas_simu.ros.parameters import NodeParameters

REPEAT_S = 0.2
"""Time in s after which the last command is repeated: robots stop when none comes."""

RESTS_S = 1.0
"""Time in s for which a robot whose commands have ceased is commanded zero."""

_SHORTEST_TIMEOUT_S = 1.0
_TIMEOUT_PERIODS = 3
_JITTER_S = 0.01

REST = (0.0, 0.0, 0.0)
NO_COMMAND = (math.nan, 0.0, math.nan)


class SiToUni(RobotNode):
    """Converts the velocity of robot i to its command: cmd_cart_vel and odom in, cmd_vel out.

    Its process (`ControlledFleet`) takes the poses for all its nodes before it steps them.

    Attributes:
        poses: Where the robots are.
        model: What kind of robot it is, with its limits.
        conversion: From the velocity to the command; it remembers the last command.
        velocity_topics: Topics of the velocities that it follows; with the filter, there are two.
        paused: Whether the robot is kept at rest.
        stopped: Whether a stop keeps it at rest.
        received_at: When the last velocity came, in s.
        sent: When the last command was published, in s.
    """

    def __init__(
        self,
        robot: int | None,
        gains: GainOptions,
        safety: FilterOptions,
        options: ControllerOptions,
        limits: VelocityLimits,
        **of_node: Any,
    ) -> None:
        """Create the topics of a robot; `of_node` is for `RobotNode`.

        With the safety filter, the robot follows what that allows. In an experiment commands are
        for the bridge, which also learns that a law has failed.
        """
        super().__init__('si_to_uni', robot, **of_node)
        self.parameters = NodeParameters(self, gains, ('komega',))
        text = 'stop after this many s without news; 0: 1 s, or three periods if they are longer'
        self._given_timeout = self.number('cmd_timeout', 0.0, text)
        source = topics.CMD_CART_VEL_ALLOWED if safety.is_on else topics.CMD_CART_VEL
        in_experiment = options.experiment
        target = topics.CMD_VEL_WANTED if in_experiment else topics.CMD_VEL
        odom = topics.mocap_topic(self.robot) if in_experiment else topics.ODOM
        self.odom_topic = self.fixed('odom_topic', odom, 'poses of the robot')
        source = self.fixed('velocity_topic', source, 'velocities to follow')
        self.velocity = self.newest(Point32, source, qos.COMMAND)
        wanted = topics.CMD_CART_VEL if safety.is_on else source
        self.velocity_topics = tuple(dict.fromkeys((wanted, source)))
        target = self.fixed('cmd_vel_topic', target, 'commands')
        own_odom = topics.ODOM  # of the robot itself, also in experiments
        self.cmd_vel = CmdVelPublisher(self, self.robot, target, own_odom, options.cmd_vel_type)
        # In an experiment the pause node takes the requests: false must not start a robot.
        self.pause_request = None if in_experiment else self.newest(Bool, topics.PAUSE, qos.EVENT)
        self._accel = safety.accel or math.inf
        self.period = 1.0 / gains.rate
        self.is_filtered, self.in_experiment = safety.is_on, in_experiment
        self.limits = limits
        self.poses: FleetPoses
        self.model: RobotModel = UNICYCLE
        self.convert_by()
        self.paused = self.stopped = False
        self.command: Command | None = None  # before the first velocity
        self.received_at = self.sent = -math.inf

    def use(self, model: RobotModel) -> None:
        """Drive the robot as its model asks for; a unicycle without limits gets the given ones."""
        has_none = isinstance(model, Unicycle) and model.limits == IDEAL
        self.model = Unicycle(self.limits) if has_none else model
        self.conversion.use([self.model])

    def convert_by(self, *script: Conversion) -> None:
        """Drive the robot by a user's own conversion, or without one by the built-in one."""
        komega = self.parameters.options.komega
        self.conversion = VelocityConversion(1, komega, self.period, self._accel, script)
        self.use(self.model)

    def expect(self, period: float) -> None:
        """Expect a velocity once per `period` in s from now on."""
        self.period = self.conversion.Ts = period

    @property
    def timeout(self) -> float:
        """How long the last command is repeated without a new velocity, in s."""
        return self._given_timeout or max(_SHORTEST_TIMEOUT_S, _TIMEOUT_PERIODS * self.period)

    def forget(self) -> None:
        """Drop a velocity that has waited for the start: its sender may have died since."""
        self.velocity()

    def step(self) -> None:
        """Convert a new velocity, or repeat the last command."""
        if message := self.velocity():
            self.take_pause()
            self.received_at, self.command = self.time.now, self.converted(message)
            self.send(self.command)
        else:
            self.repeat()

    def repeat(self) -> None:
        """Repeat the last command if it is due: zero after a time-out, and at last none.

        In an experiment nothing is repeated, as silence stops the robot until a person starts it.
        """
        self.take_pause()
        now = self.time.now
        if self.command is None or self.in_experiment or now - self.sent < REPEAT_S - _JITTER_S:
            return
        if now - self.received_at > self.timeout + RESTS_S:
            self.command = None  # a joystick may drive the robot now
            return
        if now - self.received_at > self.timeout:
            self.command = REST
        self.send(self.command)

    def take_pause(self) -> None:
        """Take a request to pause or resume the robot."""
        if self.pause_request and (request := self.pause_request()):
            self.pause(request.data)

    def converted(self, message: Point32) -> Command:
        """Return the command for a velocity, vx and vy in m/s; z is the filter's verdict."""
        if self.in_experiment and not math.isfinite(message.x + message.y):
            return NO_COMMAND  # a law that fails; the bridge stops the robot for good
        has_verdict = not self.is_filtered or math.isfinite(message.z)
        if self.poses.age(self.robot) > POSE_TIMEOUT_S or not has_verdict:
            # A robot of an experiment must not set off again because poses are back.
            return NO_COMMAND if self.in_experiment else REST
        velocity = np.array([[message.x], [message.y]])
        verdicts = np.array([int(message.z)]) if self.is_filtered else None
        self.conversion.komega = self.parameters.options.komega
        commands = self.conversion(velocity, self.poses.pose(self.robot), verdicts)
        scripts = self.conversion.scripts
        if self.in_experiment and any(getattr(one, 'has_failed', False) for one in scripts):
            return NO_COMMAND
        V, left, omega = commands[:, 0].tolist()
        return V, left, omega

    def send(self, command: Command) -> None:
        """Publish a command, unless the robot is paused: then it rests."""
        if self.paused:
            command = REST
        if command in (REST, NO_COMMAND):  # speeds rise from there
            self.conversion.last = np.zeros((3, 1))
        V, left, omega = command
        self.cmd_vel.publish(V, omega, left, self.time.clock.stamp())
        self.sent = self.time.now

    def pause(self, paused: bool) -> None:
        """Pause or resume the robot; after a stop it stays paused."""
        self.paused = paused or self.stopped
        if self.paused:
            self.send(REST)

    def stop(self) -> None:
        """Let the robot rest."""
        self.command = None
        self.send(REST)
