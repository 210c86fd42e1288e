import math
import os
import signal

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Twist
from lab_peer import BRIDGES, LabPeer
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState
from visualization_msgs.msg import MarkerArray

from setcmas_expe.bridge.bridge_decision import BridgeState, Cause, Decision, StopReason
from setcmas_expe.bridge.machine_load import OVERLOADED
from setcmas_expe.bridges import BridgedFleet
from setcmas_expe.lab.lab_file import DEFAULT_FILE, load_lab
from setcmas_simu.ros import qos

STOP = (0.0, 0.0)


@pytest.fixture
def lab(peer):
    return LabPeer(peer, ('tb3_1', 'tb3_2'))


def let_go(lab):
    """Let both robots move: all that a command needs is there."""
    lab.poses.update({1: (-1.0, 0.0, 0.5), 2: (1.0, 0.0, 0.5)})
    lab.wanted.update({1: (0.1, 0.2), 2: (0.05, 0.0)})
    lab.let_go({1: (0.1, 0.2), 2: (0.05, 0.0)})


def wait_until_paused_by(lab, reason):
    lab.peer.wait_for(lambda: reason in lab.status(1)[0].message)


def test_a_robot_moves_only_while_all_that_it_needs_is_there(start, peer, lab):
    process = start(*BRIDGES, '--nb-robots', '2')
    process.wait_for_output('without guards, robots keep their last velocity')
    process.wait_for_output('bridging robots 1-2: poses from /qualisys/tb3_1/odom')
    lab.wanted = {1: (0.1, 0.2), 2: (0.05, 0.0)}
    lab.poses[1] = (-1.0, 0.0, 0.5)
    lab.let_go()
    wait_until_paused_by(lab, 'robot 2 has not been seen yet')
    assert all(m.twist.linear.x == 0.0 for i in (1, 2) for m in lab.commands[i])

    let_go(lab)
    lab.poses[1] = None
    lab.wait_for_command(1, STOP)
    wait_until_paused_by(lab, 'robot 1: no good pose for 0.5 s')
    lab.wait_for_command(2, STOP)

    let_go(lab)
    lab.poses[1] = (0.0, 0.0, 0.0)  # what a Vicon system sends for a lost body
    lab.wait_for_command(1, STOP)
    wait_until_paused_by(lab, 'pose rejected: exactly zero')

    for wanted, reason in ((None, 'no command for 0.5 s'), ((math.nan, 0.1), 'not a number')):
        let_go(lab)
        lab.wanted[1] = wanted
        lab.wait_for_command(1, STOP)
        wait_until_paused_by(lab, reason)

    let_go(lab)
    lab.noise = 0.0
    lab.wait_for_command(1, STOP)
    lab.wait_for_command(2, STOP)
    wait_until_paused_by(lab, 'pose rejected: frozen')
    lab.noise = 1e-5

    let_go(lab)
    lab.paused = True
    lab.wait_for_command(1, STOP)
    lab.wait_for_command(2, STOP)
    let_go(lab)
    lab.paused = None
    lab.wait_for_command(1, STOP)
    peer.wait_for(lambda: 'the pause node is silent' in process.output())

    let_go(lab)
    for robot in (1, 2):
        lab.commands[robot].clear()
    process.popen.send_signal(signal.SIGTERM)
    peer.wait_for(lambda: process.popen.poll() is not None)
    assert process.wait() == 0
    peer.wait_for(lambda: lab.last(1) == lab.last(2) == STOP)
    assert 'Traceback' not in process.output()


def test_odometry_diagnostics_and_arena_are_published(start, peer, lab):
    odometry = peer.listen(Odometry, '/mocap/tb3_1/odom')
    arena = peer.listen(MarkerArray, '/arena', qos.LATCHED)
    start(*BRIDGES, '--nb-robots', '2', '--arena=-1.1,2,-1,1')
    battery = peer.publisher(BatteryState, '/tb3_1/battery_state', qos=qos.SENSOR)
    let_go(lab)
    peer.wait_for(lambda: odometry)
    battery.publish(BatteryState(percentage=87.0))
    peer.wait_for(lambda: lab.status(1)[1]['battery'] == '87')

    assert odometry[-1].header.frame_id == 'world'
    assert odometry[-1].child_frame_id == 'tb3_1/base_footprint'
    assert odometry[-1].pose.pose.position.x == -1.0
    status, values = lab.status(1)
    assert (status.name, status.message, status.level) == ('tb3_1', '', b'\x00')
    assert values['state'] == 'moving'
    assert float(values['pose_age']) < 0.5
    assert float(values['speed']) == pytest.approx(0.0, abs=0.01)
    (border,) = arena[0].markers
    assert (border.ns, border.type) == ('arena', border.LINE_STRIP)
    assert {(p.x, p.y) for p in border.points} == {(x, y) for x in (-1.1, 2) for y in (-1, 1)}

    lab.paused = True
    lab.poses = dict.fromkeys((1, 2))
    peer.wait_for(lambda: lab.status(1)[0].level == lab.status(2)[0].level == b'\x02')
    lab.poses = {1: (-1.15, 0.0, math.pi), 2: (1.0, 0.0, 0.0)}
    peer.wait_for(lambda: lab.status(1)[0].message == 'paused')
    lab.paused = False
    peer.wait_for(lambda: 'outside the arena' in lab.status(1)[0].message)
    assert lab.status(1)[1]['state'] == 'stopped'
    peer.wait_for(lambda: lab.last(1) == (0.0, 0.2))  # it may turn
    lab.wanted[1] = (-0.1, 0.0)  # backwards is inside
    lab.wait_for_command(1, (-0.1, 0.0))


def test_the_type_and_the_namespace_of_the_robot_are_followed(start, peer, tmp_path):
    path = tmp_path / 'lab.yaml'
    path.write_text(
        'robots:\n- {number: 1, namespace: lab/red}\n- {number: 2, namespace: lab/blue}\n'
    )
    start(*BRIDGES, '--lab', str(path))
    lab = LabPeer(peer, ('lab/red', 'lab/blue'), Twist)

    let_go(lab)
    assert lab.status(1)[0].hardware_id == '/lab/red/cmd_vel'


def test_wheel_odometry_begins_at_the_measured_start_poses(start, peer, lab, tmp_path):
    path = tmp_path / 'lab.yaml'
    path.write_text(
        'robots:\n- {number: 1, start: [1.0, 0.5, 1.57]}\n- {number: 2, start: [-1, 0, 0]}\n'
        "mocap: {preset: wheel_odometry, topic: '/qualisys/{name}/odom'}\n"
    )
    odometry = peer.listen(Odometry, '/mocap/tb3_1/odom')
    start(*BRIDGES, '--lab', str(path))
    lab.poses.update({1: (7.0, 5.0, 0.3), 2: (5.0, 7.0, 0.5)})  # since they were switched on
    lab.wanted.update({1: (0.1, 0.2), 2: (0.05, 0.0)})
    lab.let_go({1: (0.1, 0.2), 2: (0.05, 0.0)})

    place = odometry[-1].pose.pose.position
    assert (place.x, place.y) == pytest.approx((1.0, 0.5))

    lab.paused = True
    lab.poses[1] = (5.0, 5.0, 0.3)  # switched off and on: its odometry begins anew
    peer.wait_for(lambda: 'undo that, or restart' in lab.status(1)[0].message)
    peer.spin(2.0)
    assert 'undo that, or restart' in lab.status(1)[0].message


def test_a_robot_whose_poses_are_rare_is_not_ready(start, peer, lab):
    start(*BRIDGES, '--nb-robots', '2')
    let_go(lab)
    lab.paused, lab.poses_every = True, 6

    peer.wait_for(lambda: 'poses a second; it must send at least 4' in lab.status(1)[0].message)


@pytest.mark.parametrize(
    ('cause', 'is_named'),
    [(Cause.NO_COMMAND, True), (Cause.POSE_LATE, True), (Cause.POSE_REJECTED, False)],
)
def test_load_is_named_only_where_it_may_be_the_cause(peer, monkeypatch, cause, is_named):
    monkeypatch.setattr(os, 'getloadavg', lambda: (999.0, 999.0, 999.0))
    fleet, said = BridgedFleet(peer.node, load_lab(DEFAULT_FILE, 1)), []
    fleet.warn = said.append
    fleet.note({1: Decision(0.0, 0.0, BridgeState.STOPPED, StopReason(cause))}, 0.0)

    assert (OVERLOADED in said) is is_named
