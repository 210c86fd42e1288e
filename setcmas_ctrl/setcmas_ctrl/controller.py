"""A controller: a node that calls the control law of a robot, the function `control` of a script.

`setcmas ctrl` runs those of a whole fleet in one process (`controllers/controlled_fleet.py`), and
`control_law.py` calls the function. To run one controller alone:

    ros2 run setcmas_ctrl controller --ros-args -r __ns:=/tb3_3 -p nb_robots:=8 -p algo:=consensus
"""

from __future__ import annotations

import math
from typing import Any

from geometry_msgs.msg import Point32

from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.fleet_network import FleetNetwork
from setcmas_ctrl.laws.call_watch import CallWatch
from setcmas_ctrl.laws.control_options import LawOptions
from setcmas_ctrl.laws.script_errors import ControlError, ErrorReports, StopCall
from setcmas_ctrl.saturation import saturate
from setcmas_simu.fleet import topics
from setcmas_simu.robot_node import RobotNode
from setcmas_simu.ros import qos
from setcmas_simu.ros.parameters import NodeParameters

Velocity = tuple[float, float]

REST: Velocity = (0.0, 0.0)
NO_VELOCITY: Velocity = (math.nan, math.nan)

_ENDS_ALL = 'this process exits: it can no longer command any robot'


class Controller(RobotNode):
    """Calls the control law of robot i at 5 Hz: poses of the fleet in, cmd_cart_vel out.

    Its process (`ControlledFleet`) provides the law, and the network with the poses. Before each
    step, the process takes each odometry once for all its nodes.

    Attributes:
        law: The control law; None while its script has a mistake.
        network: What the robot knows of the others.
        watch: Times the calls of the law.
        reports: Takes the errors of the law.
        is_paused: Whether the robots are paused: the law is not called, so that its references
            do not run ahead.
        is_lost: Whether the newest pose of the robot is too old.
        without_law: Velocity in m/s in place of that of a law that fails, or cannot be called.
    """

    law: ControlLaw | None
    network: FleetNetwork
    watch: CallWatch
    reports: ErrorReports

    def __init__(
        self, robot: int | None, options: LawOptions, in_experiment: bool, **of_node: Any
    ) -> None:
        """Create the topic and the parameters of a robot; `of_node` is for `RobotNode`.

        In an experiment the velocity of a law that fails is NaN, not zero: the bridge is to know.
        """
        super().__init__('controller', robot, **of_node)
        odom = topics.mocap_topic(self.robot) if in_experiment else topics.ODOM
        self.odom_topic = self.fixed('odom_topic', odom, 'poses of the robot')
        self.parameters = NodeParameters(self, options, ('vnom',))
        self.cmd_cart_vel = self.create_publisher(Point32, topics.CMD_CART_VEL, qos.COMMAND)
        self.is_paused = self.is_lost = False
        self.without_law = NO_VELOCITY if in_experiment else REST

    def step(self) -> None:
        """Publish the velocity that the law wants, in the world frame."""
        vx, vy = REST if self.is_paused else self.velocity()
        self.cmd_cart_vel.publish(Point32(x=vx, y=vy))

    def velocity(self) -> Velocity:
        """Call the law; return its velocity in m/s, at most vnom."""
        if not (law := self.law) or self.is_lost:
            return self.without_law
        poses, adjacency = self.network.known_by(self.robot)
        try:
            with self.watch.call(self.robot, law.path):
                wanted = law(poses, self.time.t, adjacency)
            if not self.context.ok():
                text = f'{law.path.name} has shut ROS down (rclpy.shutdown)'
                error = ControlError(text, 'shutdown', _ENDS_ALL)
                self.reports.failed(self.robot, self.time.t, error)
                raise StopCall
            self.reports.succeeded(self.robot, self.time.t)
        except ControlError as error:
            self.reports.failed(self.robot, self.time.t, error)
            return self.without_law
        vx, vy = saturate(wanted, self.parameters.options.vnom).tolist()
        return vx, vy

    def stop(self) -> None:
        """Let the robot rest."""
        self.cmd_cart_vel.publish(Point32())
