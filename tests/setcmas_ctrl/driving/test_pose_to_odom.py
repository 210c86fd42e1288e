import sys

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import PoseStamped

NODE = [sys.executable, '-m', 'setcmas_ctrl.driving.pose_to_odom']


def pose(x, seconds):
    message = PoseStamped()
    message.header.frame_id = 'mocap'
    message.header.stamp.sec = int(seconds)
    message.header.stamp.nanosec = round((seconds % 1) * 1e9)
    message.pose.position.x = x
    message.pose.orientation.w = 1.0
    return message


def test_poses_become_odometry_with_velocities(start, peer):
    start(*NODE, '--robots', '1-2', '--pose-topic', '/mocap/{name}/pose')
    odometry = peer.odometry(2)
    source = peer.publisher(PoseStamped, '/mocap/tb3_2/pose')

    def answer_to(message):
        def answered():
            source.publish(message)  # best effort: repeated until it has come through
            return any(m.header.stamp == message.header.stamp for m in odometry)

        peer.wait_for(answered)
        return next(m for m in odometry if m.header.stamp == message.header.stamp)

    steps = [(1.0, 10.0), (1.03, 10.1), (1.05, 10.2), (9.0, 20.0)]
    answers = [answer_to(pose(x, seconds)) for x, seconds in steps]

    assert [m.pose.pose.position.x for m in answers] == [1.0, 1.03, 1.05, 9.0]
    assert [m.twist.twist.linear.x for m in answers] == pytest.approx([0, 0.3, 0.2, 0], abs=1e-6)
    assert answers[0].header.frame_id == 'mocap'
    assert answers[0].child_frame_id == 'tb3_2/base_footprint'


def test_malformed_robots_are_refused(start):
    process = start(*NODE, '--robots', 'x')

    assert process.wait() == 2
    assert "invalid robots 'x'" in process.output()
