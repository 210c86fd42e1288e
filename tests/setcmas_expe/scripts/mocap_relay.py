"""Motion capture on a machine of its own: it sees robots that another machine emulates."""

import itertools
import sys
from functools import partial

from nav_msgs.msg import Odometry

from setcmas_simu.fleet.topics import truth_topic
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.process import ros_process
from setcmas_simu.ros.qos import SENSOR

EVERY = 3  # of 50 Hz


def pass_on(publisher, count, message):
    if next(count) % EVERY == 0:
        message.pose.pose.position.z = 0.19
        publisher.publish(message)


with ros_process() as process:
    node = FleetNode('mocap')
    for robot in range(1, int(sys.argv[1]) + 1):
        publisher = node.create_publisher(Odometry, f'/qualisys/tb3_{robot}/odom', SENSOR)
        callback = partial(pass_on, publisher, itertools.count(robot))
        node.create_subscription(Odometry, truth_topic(robot), callback, 10)
    process.add(node)
    process.spin()
