"""What surrounds a bridge process: motion capture, controllers, a pause node and robots."""

import math
import sys

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

from setcmas_simu.fleet.planar_pose import quaternion_of_yaw

HZ = 20.0
BRIDGES = [
    sys.executable, '-m', 'setcmas_expe.bridges', '--without-motion-check',
    '--without-guard',
]  # fmt: skip


class LabPeer:
    """Publishes 20 times a second what is set here; lists what the bridge sends."""

    def __init__(self, peer, namespaces, kind=TwistStamped):
        robots = range(1, len(namespaces) + 1)
        self.peer = peer
        self.poses = dict.fromkeys(robots)  # x, y, theta; None: silence
        self.wanted = dict.fromkeys(robots)  # V, omega; None: silence
        self.paused = None
        self.noise = 1e-5
        self.poses_every = 1  # ticks
        node = peer.node
        self._mocap = {i: node.create_publisher(Odometry, f'/qualisys/tb3_{i}/odom', 5)
                       for i in robots}  # fmt: skip
        self._wanted = {i: node.create_publisher(TwistStamped, f'/tb3_{i}/cmd_vel_wanted', 1)
                        for i in robots}  # fmt: skip
        self._paused = node.create_publisher(Bool, '/paused', 1)
        self.commands = {
            i: peer.listen(kind, f'/{name}/cmd_vel') for i, name in enumerate(namespaces, start=1)
        }
        self.diagnostics = peer.listen(DiagnosticArray, '/diagnostics')
        self.ticks = 0
        node.create_timer(1 / HZ, self._publish)

    def _publish(self):
        self.ticks += 1
        for robot, pose in self.poses.items():
            if pose is not None and self.ticks % self.poses_every == 0:
                self._mocap[robot].publish(self._odometry(pose))
        for robot, wanted in self.wanted.items():
            if wanted is not None:
                message = TwistStamped()
                message.twist.linear.x, message.twist.angular.z = wanted
                self._wanted[robot].publish(message)
        if self.paused is not None:
            self._paused.publish(Bool(data=self.paused))

    def _odometry(self, pose):
        message = Odometry()
        x, y, theta = pose
        if (x, y) != (0.0, 0.0):
            message.pose.pose.position.z = 0.1
            z, w = quaternion_of_yaw(theta + self.noise * math.sin(self.ticks))
            message.pose.pose.orientation.z, message.pose.pose.orientation.w = z, w
        message.pose.pose.position.x, message.pose.pose.position.y = x, y
        message.header.stamp = self.peer.node.get_clock().now().to_msg()
        return message

    def last(self, robot):
        """Return V and omega of the last command to a robot; None before the first."""
        if not self.commands[robot]:
            return None
        message = self.commands[robot][-1]
        twist = getattr(message, 'twist', message)
        return twist.linear.x, twist.angular.z

    def wait_for_command(self, robot, command):
        self.peer.wait_for(lambda: self.last(robot) == command)

    def let_go(self, commands=None):
        """Say go, as a pause node does, and wait until robots get these commands.

        It is told once more where the bridge holds them for a reason of its own.
        """
        self._say_go()
        self.peer.wait_for(lambda: self._goes(commands or {}))

    def _say_go(self):
        """Say go after the bridge has heard a pause."""
        if self.paused is not False:
            self.paused = True
            self.peer.wait_for(self._is_paused_by_wish)
            self.paused = False

    def _goes(self, commands):
        if all(self.last(robot) == command for robot, command in commands.items()):
            return True
        if self.status(1)[0].message.startswith('paused: '):
            self.paused = True
            self._say_go()
        return False

    def _is_paused_by_wish(self):
        message = self.status(1)[0].message
        return message.startswith('paused') and not message.startswith('paused: ')

    def status(self, robot):
        """Return the newest diagnostic status of a robot, with its values as a dictionary."""
        self.peer.wait_for(lambda: self.diagnostics)
        status = self.diagnostics[-1].status[robot - 1]
        return status, {item.key: item.value for item in status.values}
