import math

import numpy as np
import pytest
from processes import CTRL

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry

from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_node import FleetNode


@pytest.fixture
def node(peer):
    return peer.add(FleetNode('poses', context=peer.context))


def test_the_newest_poses_of_a_fleet_are_shared(peer, node):
    sources = {i: (node, f'/tb3_{i}/odom') for i in (1, 3)}
    poses = FleetPoses(sources, 3)
    publishers = {i: peer.publisher(Odometry, poses.topic_of(i)) for i in sources}

    def send(robot, x):
        odometry = Odometry()
        odometry.pose.pose.position.x = x
        publishers[robot].publish(odometry)

    assert poses.missing() == [1, 3]
    for x in (1.0, 2.0):
        send(3, x)
    peer.wait_for(lambda: poses.take(10.0) or not np.isnan(poses.poses[0, 2]))
    assert poses.missing() == [1]
    assert poses.poses[:, 2].tolist() == [2.0, 0.0, 0.0]
    assert np.isnan(poses.poses[:, :2]).all()
    assert poses.new[3].pose == (2.0, 0.0, 0.0)
    poses.take(10.0)
    assert poses.new == {}

    send(3, math.nan)
    peer.wait_for(lambda: poses.take(10.5) or poses.fault(3))
    assert 'NaN' in poses.fault(3)
    assert poses.age(3) == 0.5
    assert poses.age(1) == math.inf
    send(3, 4.0)
    peer.wait_for(lambda: poses.take(11.0) or not poses.fault(3))
    assert (poses.age(3), poses.poses[0, 2]) == (0.0, 4.0)


@pytest.mark.nightly
def test_unusable_odometry_is_reported_until_the_driver_is_mended(start, peer, script):
    publisher = peer.node.create_publisher(Odometry, '/tb3_1/odom', qos.SENSOR)
    odometry, unusable = Odometry(), 'its pose is NaN or infinite'
    peer.node.create_timer(0.05, lambda: publisher.publish(odometry))
    law = script('def control(i, n, p, t):\n    return 0, 0\n')

    def is_said(text, x):
        odometry.pose.pose.position.x = x
        peer.wait_for(lambda: text in process.output())

    process = start(*CTRL, '--algo', law, '--nb-robots', '1')
    is_said(f'robot 1 (/tb3_1/odom); robot 1 sends invalid odometry: {unusable}', math.nan)
    assert 'controlling' not in process.output()
    is_said('controlling', 0.0)
    is_said(f'robot 1: no valid pose ({unusable}) for', math.nan)
    is_said('robot 1: its poses are back', 0.0)
