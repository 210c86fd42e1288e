"""A rogue on the network: tries all ways to drive robot 1, 50 times a second, until it is ended.

Its argument `guarded` lets it drive the robot past its guard, too.
"""

import sys

import rclpy
from geometry_msgs.msg import Point32, TwistStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

rclpy.init()
node = rclpy.create_node('rogue')
ahead, place = TwistStamped(), Odometry()
ahead.twist.linear.x = place.twist.twist.linear.x = 0.2
place.pose.pose.position.x, place.pose.pose.orientation.z = 3.0, 1.0
messages = {
    '/tb3_1/cmd_vel': ahead,
    '/tb3_1/cmd_vel_wanted': ahead,
    '/tb3_1/cmd_cart_vel': Point32(x=0.2),
    '/mocap/tb3_1/odom': place,
    '/paused': Bool(),
    '/emergency_stopped': Bool(),
}
if 'guarded' in sys.argv:
    messages['/tb3_1/cmd_vel_guarded'] = ahead
publishers = {topic: node.create_publisher(type(m), topic, 1) for topic, m in messages.items()}


def drive():
    for topic, message in messages.items():
        if hasattr(message, 'header'):
            message.header.stamp = node.get_clock().now().to_msg()
        publishers[topic].publish(message)


node.create_timer(0.02, drive)
print('drives', flush=True)
rclpy.spin(node)
