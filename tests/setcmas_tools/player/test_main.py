"""The player process over DDS."""

import sys

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rosbags.rosbag2 import StoragePlugin, Writer
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from terminals import Terminal

from setcmas_simu.ros import qos
from setcmas_tools.recorder.offered_qos import stored_qos

PLAYER = [sys.executable, '-m', 'setcmas_tools.player.main']
START_NS = 1_700_000_000_000_000_000
NB_MESSAGES = 50


@pytest.fixture
def recording(tmp_path, store, make):
    """A bag of 5 s with the odometry of a robot at 10 Hz, its commands, and a latched /fleet."""
    odometry = make('nav_msgs/msg/Odometry')
    command = make('geometry_msgs/msg/TwistStamped')
    announced = make('std_msgs/msg/String', {'data': 'announced'})
    with Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.MCAP) as writer:

        def write(topic, message, number):
            data = store.serialize_cdr(message, message.__msgtype__)
            writer.write(topic, START_NS + number * 10**8, data)

        def topic(name, message, profile):
            offered = stored_qos([profile])
            kind = message.__msgtype__
            return writer.add_connection(name, kind, typestore=store, offered_qos_profiles=offered)

        poses = topic('/tb3_1/odom', odometry, qos.STATE)
        commands = topic('/tb3_1/cmd_vel', command, qos.COMMAND)
        write(topic('/fleet', announced, qos.LATCHED), announced, 0)
        for number in range(NB_MESSAGES):
            odometry.pose.pose.position.x = float(number)
            write(poses, odometry, number)
            write(commands, command, number)
    return tmp_path / 'bag'


def test_everything_but_commands_is_played_and_nothing_is_lost(start, peer, recording):
    odometry = peer.listen(Odometry, '/tb3_1/odom', qos=1000)
    clock = peer.listen(Clock, '/clock', qos.CLOCK)
    player = start(*PLAYER, str(recording), '--rate', '10', '--clock')
    peer.wait_for(lambda: len(odometry) == NB_MESSAGES)
    assert peer.node.count_publishers('/tb3_1/cmd_vel') == 0

    assert player.wait() == 0
    assert [message.pose.pose.position.x for message in odometry] == list(range(NB_MESSAGES))
    assert clock[-1].clock.sec in range(START_NS // 10**9, START_NS // 10**9 + 6)
    assert 'not played: /tb3_1/cmd_vel (no robot moves because of a recording)' in player.output()


def test_it_ends_when_a_robot_comes_that_it_plays_and_late_listeners_know_of_the_fleet(
    start, peer, recording
):
    player = start(*PLAYER, str(recording), '--loop', '--start', '4')
    player.wait_for_output('playing 2 topics, 4.9 s')
    announced = peer.listen(String, '/fleet', qos.LATCHED)
    peer.wait_for(lambda: announced)
    commands = peer.listen(TwistStamped, '/tb3_1/cmd_vel')

    peer.wait_for(lambda: player.popen.poll() is not None)
    assert player.wait() == 1
    assert 'error: playing has ended: tb3_1 is there already: /peer listens' in player.output()
    assert commands == []


def test_space_pauses_and_q_stops(peer, recording):
    odometry = peer.listen(Odometry, '/tb3_1/odom', qos=1000)
    terminal = Terminal('play', str(recording), '--rate', '0.5')
    try:
        peer.wait_for(lambda: odometry)
        terminal.press(' ')
        terminal.wait_for(r'paused at \d\.\d s')
        peer.spin(0.3)  # what was on its way
        paused = len(odometry)
        peer.spin(0.5)
        assert len(odometry) == paused
        terminal.press(' ')
        terminal.wait_for(r'playing on at \d\.\d s')
        peer.wait_for(lambda: len(odometry) > paused)
        terminal.press('q')
        assert terminal.wait() == 0
    finally:
        terminal.close()
