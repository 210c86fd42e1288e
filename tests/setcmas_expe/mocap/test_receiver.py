"""One topic for all bodies, in messages that have a wheel: those of its drivers have none."""

import sys
from dataclasses import replace
from types import SimpleNamespace

import pytest
from processes import refuses

pytest.importorskip('rclpy')

from geometry_msgs.msg import PoseStamped
from lab_peer import BRIDGES, LabPeer
from ros_peer import Peer
from visualization_msgs.msg import Marker, MarkerArray

from setcmas_expe.mocap.receiver import MocapReceiver
from setcmas_expe.mocap.sources import MOCAP_SOURCES, read_pose_stamped
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw
from setcmas_simu.ros import qos

NAMES = ('3', 'Red.Red')
GOES = (0.1, 0.2)
STOP = (0.0, 0.0)
WITH_MARKERS = """
import runpy, sys
from dataclasses import replace
from setcmas_expe.mocap import mocap_presets
def read(message):
    for one in message.markers:
        yield one.ns, mocap_presets.sample_of(one.header, one.pose.position, one.pose.orientation)
mocap_presets.MOCAP4R2 = replace(
    mocap_presets.MOCAP4R2, message_type='visualization_msgs/msg/MarkerArray', read=read
)
sys.argv[0] = sys.argv.pop(1)
runpy.run_module(sys.argv[0], run_name='__main__', alter_sys=True)
"""
"""Runs a module in which mocap4r2 sends markers."""


def with_markers(module, *arguments):
    return [sys.executable, '-c', WITH_MARKERS, module, *arguments]


def write_lab(folder):
    robots = [f'  - {{number: {i}, mocap_name: "{name}"}}' for i, name in enumerate(NAMES, 1)]
    lines = ['robots:', *robots, 'mocap: {preset: mocap4r2}', 'arena: {x: [-3, 3], y: [-3, 3]}']
    path = folder / 'lab.yaml'
    path.write_text('\n'.join(lines))
    return path


@pytest.fixture
def see(peer):
    """Return a function that tells motion capture what it sees from now on."""
    seen, count = [], [0]
    publisher = peer.node.create_publisher(MarkerArray, '/rigid_bodies', qos.SENSOR)

    def publish():
        count[0] += 1
        message = MarkerArray()
        for name, x, y, theta in seen:
            marker = Marker(ns=name)
            marker.header.stamp = peer.node.get_clock().now().to_msg()
            place, q = marker.pose.position, marker.pose.orientation
            place.x, place.y, place.z = x + 1e-6 * (count[0] % 7), y, 0.19  # noise, as there is
            q.z, q.w = quaternion_of_yaw(theta)
            message.markers.append(marker)
        publisher.publish(message)

    peer.node.create_timer(0.02, publish)

    def see_bodies(*bodies):
        seen[:] = bodies

    return see_bodies


def test_robots_find_their_bodies_in_any_order_missing_or_there_twice(start, peer, see, tmp_path):
    one, two = (NAMES[0], -1.0, 0.0, 0.5), (NAMES[1], 1.0, 0.0, 0.0)
    see(two, ('stranger', 0.5, 0.5, 0.0), one)
    process = start(*with_markers(*BRIDGES[2:], '--lab', str(write_lab(tmp_path))))
    process.wait_for_output('poses from /rigid_bodies (mocap4r2)')
    lab = LabPeer(peer, ('tb3_1', 'tb3_2'))
    lab.wanted = {1: GOES, 2: GOES}
    lab.let_go({1: GOES, 2: GOES})

    see(one, two)
    lab.wait_for_command(1, GOES)
    see(two)
    lab.wait_for_command(1, STOP)
    peer.wait_for(lambda: 'robot 1: no good pose for 0.5 s' in lab.status(1)[0].message)

    see(two, one)
    lab.let_go({1: GOES, 2: GOES})
    see(one, two, (NAMES[0], -1.02, 0.0, 0.5))
    lab.wait_for_command(1, STOP)
    twice = f"two bodies are called '{NAMES[0]}' on /rigid_bodies"
    peer.wait_for(lambda: twice in lab.status(1)[0].message)
    assert 'Traceback' not in process.output()


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
