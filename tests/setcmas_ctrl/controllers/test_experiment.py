import pytest
from processes import CTRL

pytest.importorskip('rclpy')

from geometry_msgs.msg import TwistStamped
from lab_peer import LabPeer
from nav_msgs.msg import Odometry


def lab_of_one_robot(peer):
    """Return a lab with motion capture of a robot, and a list of the commands that it gets."""
    odometry = peer.node.create_publisher(Odometry, '/mocap/tb3_1/odom', 1)
    peer.node.create_timer(0.05, lambda: odometry.publish(Odometry()))
    wanted = peer.listen(TwistStamped, '/tb3_1/cmd_vel_wanted')
    return LabPeer(peer, ('tb3_1',)), wanted


def test_the_time_of_laws_stands_still_while_an_experiment_is_paused(start, peer, script):
    law = script('def control(i, n, poses, t):\n    return 0.1 + 1e-3 * t, 0.0\n')
    lab, wanted = lab_of_one_robot(peer)
    process = start(*CTRL, '--algo', law, '--nb-robots', '1', '--experiment')

    def speed():
        return wanted[-1].twist.linear.x if wanted else 0.0

    def times():
        """Return each t of a call, which this process may read much later."""
        speeds = [message.twist.linear.x for message in wanted]
        return [1e3 * (speed - 0.1) for speed in speeds if speed]

    peer.wait_for(lambda: 'controlling robot 1' in process.output())
    assert speed() == 0.0  # no pause node yet
    lab.paused = True
    peer.spin(1.0)
    assert all(message.twist.linear.x == 0.0 for message in wanted)
    lab.paused = False
    peer.wait_for(times)
    assert times()[0] < 0.9  # more time has passed since the controller started
    peer.wait_for(lambda: times()[-1] > 1.0)
    lab.paused = True
    peer.wait_for(lambda: speed() == 0.0)
    before = times()
    peer.spin(2.0)
    lab.paused = False
    peer.wait_for(lambda: len(times()) > len(before))
    assert before[-1] < times()[len(before)] < before[-1] + 1.5
    lab.paused = None  # the pause node has died
    peer.wait_for(lambda: speed() == 0.0)


def test_poses_of_motion_capture_are_waited_for(start):
    process = start(*CTRL, '--algo', 'nav_wp', '--nb-robots', '1', '--experiment')

    process.wait_for_output('robot 1 (/mocap/tb3_1/odom); does motion capture see it?')
