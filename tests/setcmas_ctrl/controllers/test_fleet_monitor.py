import pytest

pytest.importorskip('rclpy')

from processes import CTRL, SIMU
from ros_peer import velocity
from std_msgs.msg import Bool

from setcmas_simu.ros import qos


def test_pause_holds_one_robot_or_the_fleet_at_zero_and_an_emergency_stop_to_the_end(start, peer):
    start(*SIMU, '--nb-robots', '2')
    commands = [peer.cmd_vel(robot) for robot in (1, 2)]
    ctrl = start(*CTRL, '--algo', 'consensus')
    ctrl.wait_for_output('controlling')
    pause_first = peer.publisher(Bool, '/tb3_1/pause')
    pause_all = peer.publisher(Bool, '/pause')

    def stands(index):
        return all(velocity(m) == (0.0, 0.0) for m in commands[index][-3:])

    peer.wait_for(lambda: all(commands))
    pause_first.publish(Bool(data=True))
    peer.wait_for(lambda: stands(0) and not stands(1))
    pause_all.publish(Bool(data=True))
    peer.wait_for(lambda: stands(0) and stands(1))
    ctrl.wait_for_output('paused by /pause')
    pause_all.publish(Bool(data=False))
    peer.wait_for(lambda: not stands(0) and not stands(1))
    ctrl.wait_for_output('started by /pause')

    peer.publisher(Bool, '/emergency_stop', qos=qos.LATCHED).publish(Bool(data=True))
    ctrl.wait_for_output('stopped by /emergency_stop: restart this process to continue')
    peer.wait_for(lambda: stands(0) and stands(1))
    pause_all.publish(Bool(data=False))
    pause_first.publish(Bool(data=False))
    for messages in commands:
        peer.wait_for_new(messages, 5)
    assert stands(0)
    assert stands(1)
