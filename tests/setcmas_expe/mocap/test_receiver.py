"""What a receiver passes on: of topics of all bodies and of one, of messages and of nonsense."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from processes import refuses

pytest.importorskip('rclpy')

from geometry_msgs.msg import PoseStamped
from ros_peer import Peer
from visualization_msgs.msg import Marker, MarkerArray

from setcmas_expe.mocap.receiver import MocapReceiver
from setcmas_expe.mocap.sources import MOCAP_SOURCES, MocapSource, read_pose_stamped, sample_of
from setcmas_simu.ros import qos


def read_markers(message):
    for marker in message.markers:
        yield marker.ns, sample_of(marker.header, marker.pose.position, marker.pose.orientation)


FOR_ALL = MocapSource('/rigid_bodies', 'visualization_msgs/msg/MarkerArray', read_markers)
"""One topic for all bodies, in messages that have a wheel: those of its drivers have none."""


@pytest.mark.parametrize(
    ('seen', 'taken', 'twice'),
    [
        (('Red.Red', 'stranger', '3'), {'3', 'Red.Red'}, ''),
        (('Red.Red',), {'Red.Red'}, ''),
        (('3', 'Red.Red', '3'), {'Red.Red'}, "two bodies are called '3' on /rigid_bodies"),
    ],
)
def test_robots_find_their_bodies_in_any_order_missing_or_there_twice(peer, seen, taken, twice):
    found = set()
    takers = {name: lambda _, name=name: found.add(name) for name in ('3', 'Red.Red')}
    receiver = MocapReceiver(peer.node, FOR_ALL, y_up=False, bodies=takers)
    driver = peer.publisher(MarkerArray, '/rigid_bodies', qos=qos.SENSOR)
    driver.publish(MarkerArray(markers=[Marker(ns=name) for name in seen]))
    peer.wait_for(lambda: receiver.take() or receiver.bodies())

    assert found == taken
    assert receiver.trouble('3') == twice
    assert receiver.bodies() == sorted(set(seen))


def part(**fields):
    return SimpleNamespace(**fields)


@pytest.mark.parametrize(
    ('preset', 'bodies', 'name'),
    [('mocap4r2', 'rigidbodies', 'rigid_body_name'), ('motion_capture_tracking', 'poses', 'name')],
)
def test_bodies_in_messages_of_drivers_are_read(preset, bodies, name):
    position, orientation = part(x=1.0, y=2.0, z=0.2), part(x=0.0, y=0.0, z=0.6, w=0.8)
    body = part(**{name: 'Red.Red', 'pose': part(position=position, orientation=orientation)})
    header = part(stamp=part(sec=3, nanosec=500_000_000))
    message = part(**{'header': header, bodies: [body]})

    [(found, sample)] = MOCAP_SOURCES.get(preset).samples('', message)
    assert (found, sample.stamp) == ('Red.Red', 3.5)
    assert (sample.position, sample.orientation) == ((1.0, 2.0, 0.2), (0.0, 0.0, 0.6, 0.8))


def test_a_source_that_cannot_read_its_messages_says_so_and_the_others_work(peer):
    def read(message):
        if message.header.frame_id:
            raise ValueError(f'no frame\n{message.header.frame_id}')
        yield from read_pose_stamped(message)

    source = replace(MOCAP_SOURCES.get('vrpn'), read=read)
    taken = {'a': [], 'b': []}
    takers = {name: samples.append for name, samples in taken.items()}
    receiver = MocapReceiver(peer.node, source, y_up=False, bodies=takers)
    bad, good = PoseStamped(), PoseStamped()
    bad.header.frame_id = 'mocap'
    a = peer.publisher(PoseStamped, '/vrpn_mocap/a/pose', qos=qos.SENSOR)
    b = peer.publisher(PoseStamped, '/vrpn_mocap/b/pose', qos=qos.SENSOR)

    def until(condition, to_a):
        def sent():
            a.publish(to_a)
            b.publish(good)
            return condition()

        peer.wait_for(sent)

    until(lambda: receiver.take() or (receiver.trouble('a') and taken['b']), bad)
    reason = 'messages on /vrpn_mocap/a/pose cannot be read: ValueError: no frame mocap'
    assert receiver.trouble('a') == reason
    assert receiver.trouble('b') == ''
    assert taken['a'] == []
    until(lambda: receiver.take() or (taken['a'] and not receiver.trouble('a')), good)


@pytest.mark.parametrize(
    ('more', 'message'),
    [
        ((), 'sudo apt install ros-jazzy-mocap4r2-msgs'),
        (('--emulate',), 'mocap4r2 sends mocap4r2_msgs/msg/RigidBodies on'),
    ],
)
def test_a_missing_message_package_or_emulation_is_reported_before_anything_starts(
    tmp_path, more, message
):
    command = ('expe', '--algo', 'nav_wp', '--mocap', 'mocap4r2', *more)
    refuses(*command, message=message, cwd=tmp_path)


def test_poses_of_another_type_are_named(peer, domain):
    receiver = MocapReceiver(peer.node, MOCAP_SOURCES.get('vrpn'), False, {'a': lambda _: None})

    def named():
        receiver.look_around()
        return receiver.trouble('a')

    with Peer(domain) as driver:
        driver.node.create_publisher(Marker, '/vrpn_mocap/a/pose', qos.SENSOR)
        peer.wait_for(named)
        assert 'carries visualization_msgs/msg/Marker, but the lab file expects geom' in named()
