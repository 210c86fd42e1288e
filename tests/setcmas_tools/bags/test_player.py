"""The player process over DDS."""

import sys

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rosbags.rosbag2 import StoragePlugin, Writer
from std_msgs.msg import String

from setcmas_simu.errors import SetcmasError
from setcmas_simu.ros import qos
from setcmas_tools.bags.bag_reader import open_bag
from setcmas_tools.bags.player import is_shown, played_topics, robots_in_use
from setcmas_tools.bags.recorder import stored_qos

PLAYER = [sys.executable, '-m', 'setcmas_tools.bags.player']
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
    player = start(*PLAYER, str(recording), '--rate', '10')
    peer.wait_for(lambda: len(odometry) == NB_MESSAGES)
    assert peer.node.count_publishers('/tb3_1/cmd_vel') == 0

    assert player.wait() == 0
    assert [message.pose.pose.position.x for message in odometry] == list(range(NB_MESSAGES))
    assert (
        'not played: /tb3_1/cmd_vel (only poses, communication and drawings are)'
        in player.output()
    )


def test_it_ends_when_a_robot_comes_that_it_plays_and_late_listeners_know_of_the_fleet(
    start, peer, recording
):
    player = start(*PLAYER, str(recording), '--rate', '0.2')
    player.wait_for_output('playing 2 topics, 4.9 s')
    announced = peer.listen(String, '/fleet', qos.LATCHED)
    peer.wait_for(lambda: announced)
    commands = peer.listen(TwistStamped, '/tb3_1/cmd_vel')

    peer.wait_for(lambda: player.popen.poll() is not None)
    assert player.wait() == 2
    assert 'error: playing stopped: tb3_1 is in use: /peer listens' in player.output()
    assert commands == []


PLAYED = ['/tb3_1/odom', '/tb3_2/odom', '/fleet']


def test_another_node_publishes_one_of_their_topics(peer):
    peer.node.create_publisher(Odometry, '/tb3_2/odom', 1)

    peer.wait_for(lambda: robots_in_use(peer.node, PLAYED))
    assert robots_in_use(peer.node, PLAYED) == 'another node publishes /tb3_2/odom'
    assert robots_in_use(peer.node, PLAYED, own=1) == ''


def test_omissions_are_reported(tmp_path, write_bag, make):
    names = {'/fleet': 'String', '/tb3_1/reset': 'Empty', '/tb3_1/links': 'Float64MultiArray'}
    messages = [(name, 0, make(f'std_msgs/msg/{kind}')) for name, kind in names.items()]
    messages += [
        ('/tb3_1/links', 1, make('std_msgs/msg/Empty')),
        ('/tb3_1/message', 1, make('lab_msgs/msg/Reading')),
    ]
    with open_bag(write_bag(tmp_path / 'bag', messages)) as bag:
        classes, notes = played_topics(bag)

    assert [topic.name for topic in classes] == ['/fleet', '/tb3_1/links']
    assert notes == [
        'not played: /tb3_1/links (recorded with two types)',
        'not played: /tb3_1/message (no Python package lab_msgs with it is installed)',
        'not played: /tb3_1/reset (only poses, communication and drawings are)',
    ]


def test_a_bag_of_commands_alone_is_refused(tmp_path, write_bag, make):
    messages = [('/tb3_1/reset', 0, make('std_msgs/msg/Empty'))]
    with (
        open_bag(write_bag(tmp_path / 'commands', messages)) as bag,
        pytest.raises(SetcmasError, match='no topic is left to play; not played: /tb3_1/reset'),
    ):
        played_topics(bag)


@pytest.mark.parametrize(
    ('name', 'msgtype', 'shown'),
    [
        ('/tb3_1/odom', 'nav_msgs/msg/Odometry', True),
        ('/mocap/tb3_1/odom', 'nav_msgs/msg/Odometry', True),
        ('/tb3_1/wp_ref', 'visualization_msgs/msg/MarkerArray', True),
        ('/diagnostics', 'diagnostic_msgs/msg/DiagnosticArray', True),
        ('/tb3_1/cmd_vel', 'geometry_msgs/msg/TwistStamped', False),
        ('/tb3_1/cmd_cart_vel', 'geometry_msgs/msg/Point32', False),
        ('/tb3_1/bridge_state', 'diagnostic_msgs/msg/DiagnosticStatus', False),
        ('/paused', 'std_msgs/msg/Bool', False),
        ('/odom', 'nav_msgs/msg/Odometry', False),
        ('/rosout', 'rcl_interfaces/msg/Log', False),
    ],
)
def test_what_robots_may_act_on_is_never_played(name, msgtype, shown):
    assert is_shown(name, msgtype) == shown
