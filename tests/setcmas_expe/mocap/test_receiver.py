"""One topic for all bodies: a driver of another vendor, and stand-ins for message packages."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from processes import refuses, run_setcmas

pytest.importorskip('rclpy')
pytest.importorskip('cyclonedds')

from geometry_msgs.msg import PoseStamped
from lab_peer import BRIDGES, LabPeer

from setcmas_expe.mocap.receiver import MocapReceiver
from setcmas_expe.mocap.sources import MOCAP_SOURCES, read_pose_stamped
from setcmas_simu.ros import qos

TESTS = Path(__file__).parents[2]
DRIVER = TESTS / 'setcmas_expe' / 'scripts' / 'mocap_for_all.py'
INSTALLED = {'PYTHONPATH': str(TESTS / 'stand_ins')}
SOURCES = [
    ('motion_capture_tracking', 'poses', ('tb3_1', 'tb3_2')),
    ('mocap4r2', 'rigid_bodies', ('3', 'Red.Red')),
]
GOES = (0.1, 0.2)
STOP = (0.0, 0.0)


def write_lab(folder, preset, names):
    robots = [f'  - {{number: {i}, mocap_name: "{name}"}}' for i, name in enumerate(names, 1)]
    lines = ['robots:', *robots, f'mocap: {{preset: {preset}}}', 'arena: {x: [-3, 3], y: [-3, 3]}']
    path = folder / 'lab.yaml'
    path.write_text('\n'.join(lines))
    return path


@pytest.fixture
def see(start, tmp_path, domain):
    """Return a function that starts a driver on a topic, or changes what it sees."""
    path = tmp_path / 'seen.json'

    def see_bodies(*bodies, topic=None):
        (tmp_path / 'new.json').write_text(json.dumps(bodies))
        (tmp_path / 'new.json').replace(path)
        if topic:
            start(sys.executable, str(DRIVER), str(domain), topic, str(path))

    return see_bodies


@pytest.mark.parametrize(('preset', 'topic', 'names'), SOURCES)
def test_robots_find_their_bodies_in_any_order_missing_or_there_twice(
    start, peer, see, tmp_path, preset, topic, names
):
    one, two = (names[0], -1.0, 0.0, 0.5), (names[1], 1.0, 0.0, 0.0)
    see(two, ('stranger', 0.5, 0.5, 0.0), one, topic=topic)
    process = start(*BRIDGES, '--lab', str(write_lab(tmp_path, preset, names)), env=INSTALLED)
    process.wait_for_output(f'poses from /{topic} ({preset})')
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
    see(one, two, (names[0], -1.02, 0.0, 0.5))
    lab.wait_for_command(1, STOP)
    twice = f"two bodies are called '{names[0]}' on /{topic}"
    peer.wait_for(lambda: twice in lab.status(1)[0].message)
    assert 'Traceback' not in process.output()


def test_the_doctor_shows_bodies_rates_and_missing_poses(see, tmp_path, peer):
    preset, topic, names = SOURCES[0]
    see(('Blue', 0.0, 1.0, 0.0), (names[0], -1.0, 0.5, 0.0), topic=topic)
    peer.wait_for(lambda: peer.node.count_publishers(f'/{topic}'))

    result = run_setcmas('doctor', '--lab', str(write_lab(tmp_path, preset, names)), **INSTALLED)

    one, two = (line for line in result.stdout.splitlines() if line.startswith('tb3_'))
    assert '-1.00, 0.50' in one
    assert 'silent' in two
    assert f'nothing on /{topic}' in result.stdout
    sent = f'motion capture sends {", ".join(sorted(("Blue", names[0])))}'
    assert sent in ' '.join(result.stdout.split())
    assert result.returncode == 1


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

    until(lambda: receiver.trouble('a') and taken['b'], bad)
    reason = 'messages on /vrpn_mocap/a/pose cannot be read: ValueError: no frame mocap'
    assert receiver.trouble('a') == reason
    assert receiver.trouble('b') == ''
    assert taken['a'] == []
    until(lambda: taken['a'] and not receiver.trouble('a'), good)


def test_a_missing_message_package_is_reported_before_anything_starts(tmp_path):
    command = ('expe', '--algo', 'nav_wp', '--mocap', 'mocap4r2')
    refuses(*command, message='sudo apt install ros-jazzy-mocap4r2-msgs', cwd=tmp_path)


def test_an_emulated_lab_sends_a_topic_per_body(tmp_path):
    command = ('expe', '--algo', 'nav_wp', '--emulate', '--mocap', 'mocap4r2')
    refuses(*command, message='mocap4r2 sends mocap4r2_msgs/msg/RigidBodies on', cwd=tmp_path)
