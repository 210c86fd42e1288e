from unittest.mock import Mock

import pytest

pytest.importorskip('rclpy')

from processes import CTRL, SIMU
from ros_peer import velocity
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from setcmas_ctrl.controllers.fleet_pause import FleetPause
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
    assert not peer.call(SetBool, '/controllers/pause', data=False).success
    for messages in commands:
        peer.wait_for_new(messages, 5)
    assert stands(0)
    assert stands(1)


class Robot:
    paused = stopped = False

    def pause(self, paused):
        self.paused = paused


def test_a_flood_of_pauses_does_not_fill_the_terminal(capsys, monkeypatch):
    now = [0.0]
    monkeypatch.setattr('time.monotonic', lambda: now[0])
    pauses = FleetPause(Mock(), [Robot()], Mock())
    for i in range(1000):
        pauses._on_pause(Bool(data=i % 2 == 0))
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 10
    assert lines[-1] == 'started by /pause; similar lines are hidden for now'

    now[0] = 11.0
    pauses._on_pause(Bool(data=True))
    assert capsys.readouterr().out == 'paused by /pause\n'
