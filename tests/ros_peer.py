"""A node of the tests' own, which talks to the nodes under test over DDS."""

import contextlib
import time
from collections import defaultdict

import rclpy
from geometry_msgs.msg import Point32, TwistStamped
from nav_msgs.msg import Odometry
from processes import TIMEOUT_S
from rcl_interfaces.srv import SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from setcmas_simu.ros.dds_setup import dds_setup


class Peer:
    """Publishes, subscribes, and waits for conditions."""

    def __init__(self, domain: int) -> None:
        self.context = rclpy.Context()
        with dds_setup():
            rclpy.init(context=self.context, domain_id=domain)
        self.node = Node('peer', context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.messages = defaultdict(list)
        self.ends = contextlib.ExitStack()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.ends.close()
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)

    def add(self, node):
        """Return a node under test in this process, which is destroyed with this one."""
        self.ends.callback(node.destroy_node)
        return node

    def listen(self, kind, topic: str, qos=50) -> list:
        """Return the list that messages of a topic are appended to from now on."""
        kept = self.messages[topic]
        self.node.create_subscription(kind, topic, kept.append, qos)
        return kept

    def odometry(self, robot: int) -> list:
        return self.listen(Odometry, f'/tb3_{robot}/odom')

    def cmd_vel(self, robot: int, kind=TwistStamped) -> list:
        return self.listen(kind, f'/tb3_{robot}/cmd_vel')

    def cmd_cart_vel(self, robot: int) -> list:
        return self.listen(Point32, f'/tb3_{robot}/cmd_cart_vel')

    def publisher(self, kind, topic: str, listeners: int = 1, qos=10):
        """Return a publisher that has been matched by listeners."""
        publisher = self.node.create_publisher(kind, topic, qos)
        self.wait_for(lambda: publisher.get_subscription_count() >= listeners)
        return publisher

    def call(self, kind, name: str, **fields):
        """Call a service and return its response."""
        client = self.node.create_client(kind, name)
        self.wait_for(client.service_is_ready)
        answer = client.call_async(kind.Request(**fields))
        self.wait_for(answer.done)
        return answer.result()

    def set_parameter(self, node: str, name: str, value) -> str:
        """Set a parameter of another node, and return the reason if it refuses."""
        parameter = Parameter(name, value=value).to_parameter_msg()
        answer = self.call(SetParameters, f'{node}/set_parameters', parameters=[parameter])
        return answer.results[0].reason

    def wait_for(self, condition, timeout: float = TIMEOUT_S) -> None:
        """Serve callbacks until a condition holds; fails if it never does."""
        deadline = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < deadline, 'the condition did not come true in time'
            self.executor.spin_once(timeout_sec=0.05)

    def wait_for_new(self, messages: list, count: int = 1, timeout: float = TIMEOUT_S) -> list:
        """Wait for further messages and return them."""
        seen = len(messages)
        self.wait_for(lambda: len(messages) >= seen + count, timeout)
        return messages[seen:]

    def take_all(self) -> None:
        """Take the messages that have arrived: what this process has sent arrives at once."""
        for subscription in self.node.subscriptions:
            handle, kind = subscription.handle, subscription.msg_type
            while taken := handle.take_message(kind, subscription.raw):
                subscription.callback(taken[0])

    def spin(self, seconds: float) -> None:
        """Serve callbacks for a while, to see that something does not happen."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)


def position(odometry) -> tuple[float, float]:
    return odometry.pose.pose.position.x, odometry.pose.pose.position.y


def twist_stamped(V: float, omega: float) -> TwistStamped:
    message = TwistStamped()
    message.twist.linear.x, message.twist.angular.z = V, omega
    return message


def velocity(command) -> tuple[float, float]:
    return command.twist.linear.x, command.twist.angular.z
