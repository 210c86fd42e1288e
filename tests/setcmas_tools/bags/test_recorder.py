import signal
import sys

import pytest
from recordings import RECORDER, offered, recorded, wait_until_on_disk

from setcmas_tools.bags.bag_reader import open_bag

pytest.importorskip('rclpy')

from geometry_msgs.msg import Point32
from rcl_interfaces.srv import ListParameters
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.highlevel import AnyReader
from std_msgs.msg import String, UInt16
from stereo_msgs.msg import DisparityImage

from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_topic import Announcement, FleetAnnouncer
from setcmas_tools.bags import recorder
from setcmas_tools.bags.recorder import ArrivalTimes, Received

LATCHED = QoSProfile(depth=20, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=20, reliability=ReliabilityPolicy.BEST_EFFORT)


def test_every_topic_and_those_that_appear_later(record, peer, bag):
    recorder = record()
    first = peer.publisher(UInt16, '/first', qos=100)
    for i in range(100):
        first.publish(UInt16(data=i))
    later = peer.publisher(Point32, '/later')
    later.publish(Point32(x=1.5))
    wait_until_on_disk(peer, bag, '/first', 100)
    wait_until_on_disk(peer, bag, '/later')

    assert recorder.end(signal.SIGINT) == 0
    assert [message.data for message in recorded(bag, '/first')] == list(range(100))
    assert [message.x for message in recorded(bag, '/later')] == [1.5]
    assert recorder.output().count('recording ') == 1
    assert 'recorded 101 messages of 2 topics in ' in recorder.output()


def test_a_namespace_is_recorded_without_its_name_and_without_other_fleets(record, peer, bag):
    publishers = {
        name: peer.node.create_publisher(String, name, qos.LATCHED)
        for name in ('/a/tb3_1/text', '/a/fleet', '/b/tb3_1/text', '/b/fleet')
    }
    for name, publisher in publishers.items():
        publisher.publish(String(data=name))
    recorder = record('--ros-args', '-r', '__ns:=/a')
    wait_until_on_disk(peer, bag, '/tb3_1/text')
    wait_until_on_disk(peer, bag, '/fleet')
    names = peer.call(ListParameters, '/a/recorder/list_parameters').result.names
    recorder.end()

    assert 'use_sim_time' in names
    assert [message.data for message in recorded(bag, '/tb3_1/text')] == ['/a/tb3_1/text']
    with open_bag(bag) as opened:
        of_robots = {topic.name for topic, _, _ in opened.messages() if 'tb3' in topic.name}
    assert of_robots == {'/tb3_1/text'}


def test_chosen_topics_only_though_their_publishers_guarantee_nothing(record, peer, bag):
    recorder = record('--topics', 'wanted', '/missing')
    wanted = peer.publisher(UInt16, '/wanted', qos=BEST_EFFORT)
    unwanted = peer.node.create_publisher(UInt16, '/unwanted', 10)
    unwanted.publish(UInt16())
    wanted.publish(UInt16(data=7))
    wait_until_on_disk(peer, bag, '/wanted')
    assert unwanted.get_subscription_count() == 0
    recorder.end()

    assert [message.data for message in recorded(bag, '/wanted')] == [7]
    assert offered(bag, '/wanted')[0]['reliability'] == 'best_effort'
    assert '/missing was never published' in recorder.output()
    assert '/wanted was never published' not in recorder.output()


def test_an_empty_recording_is_closed_well(record, bag):
    recorder = record()

    assert recorder.end() == 0
    assert f'nothing was recorded: no message arrived; {bag} is an empty bag' in recorder.output()
    with AnyReader([bag]) as reader:
        assert reader.message_count == 0


def test_a_full_disk_gets_one_line_and_leaves_what_was_written(start, peer, bag):
    # A limit on the size of files: the same OSError as that of a full disk, without a disk.
    code = (
        'import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (2**21,) * 2)\n'
        'from setcmas_tools.bags.recorder import main; sys.exit(main())\n'
    )
    recorder = start(sys.executable, '-c', code, '-o', str(bag))
    publisher = peer.publisher(String, '/text', qos=100)
    message = String(data='x' * 50_000)

    def has_ended():
        publisher.publish(message)
        return recorder.popen.poll() is not None

    peer.wait_for(has_ended)
    assert recorder.wait() == 1
    lines = [line for line in recorder.output().splitlines() if 'error: ' in line]
    assert lines == [
        f"error: recording to '{bag}' stopped: File too large; earlier messages are readable"
    ]
    assert 'Traceback' not in recorder.output()
    with open_bag(bag) as opened:
        texts = [topic.decode(data).data for topic, _, data in opened.messages()]
    assert texts
    assert set(texts) == {message.data}


def test_a_bag_that_exists_is_not_touched(start, domain, bag):
    bag.mkdir()
    recorder = start(*RECORDER, '-o', str(bag))

    assert recorder.wait() == 2
    assert recorder.output() == f"error: '{bag}' exists already; it must be a new folder\n"
    assert list(bag.iterdir()) == []


def test_robots_with_another_real_time_factor_are_told_of(record, peer, bag):
    FleetAnnouncer(peer.node).announce(Announcement(1, (1,), rtf=5.0))
    recorder = record()
    peer.wait_for(lambda: 'record with the same option' in recorder.output())

    assert recorder.end() == 0


def test_latched_messages_are_recorded_once_whoever_publishes_later(record, peer, bag):
    latched = peer.node.create_publisher(UInt16, '/latched', LATCHED)
    for i in range(10):
        latched.publish(UInt16(data=i))
    recorder = record()
    wait_until_on_disk(peer, bag, '/latched', 10)
    other = peer.node.create_publisher(UInt16, '/latched', 10)

    def is_recorded():
        other.publish(UInt16(data=10))
        with open_bag(bag) as opened:
            return sum(topic.name == '/latched' for topic, _, _ in opened.messages()) > 10

    peer.wait_for(is_recorded)
    recorder.end()

    values = [message.data for message in recorded(bag, '/latched')]
    assert values[:10] == list(range(10))
    assert set(values[10:]) == {10}


def test_type_without_a_python_package_is_reported_once(record, peer, bag, tmp_path):
    package = tmp_path / 'hidden' / 'stereo_msgs'
    package.mkdir(parents=True)
    (package / '__init__.py').write_text('raise ImportError')
    path = ':'.join([str(package.parent), *sys.path])
    publisher = peer.node.create_publisher(DisparityImage, '/stereo', 10)
    recorder = record(env={'PYTHONPATH': path})
    number = peer.publisher(UInt16, '/number')
    number.publish(UInt16(data=7))
    wait_until_on_disk(peer, bag, '/number')
    peer.node.destroy_publisher(publisher)
    peer.node.create_publisher(DisparityImage, '/stereo', 10)
    peer.wait_for(lambda: peer.node.count_publishers('/stereo') == 1)
    peer.spin(0.5)

    assert recorder.end() == 0
    line = (
        '/stereo (stereo_msgs/msg/DisparityImage) is not recorded: '
        'no Python package stereo_msgs with it is installed'
    )
    assert recorder.output().splitlines().count(line) == 1
    assert len(recorded(bag, '/number')) == 1


class Clocks:
    """A system clock that is set, and a steady one, in ns."""

    def __init__(self):
        self.system, self.steady = 1_000_000, 500

    def time_ns(self):
        return self.system

    def monotonic_ns(self):
        return self.steady


@pytest.mark.parametrize(
    ('rtf', 'jump', 'received', 'stamps'),
    [
        (1.0, 0, (20, 10, 50), [10, 20, 50]),
        (1.0, 0, (20, 150, 0), [100, 100, 150]),  # 0 is unknown
        (5.0, 0, (20, 10), [50, 100]),
        (1.0, 3600, (3620, 3700), [20, 100]),
        (1.0, -3600, (-3580, -3500), [20, 100]),
    ],
)
def test_times_go_as_those_of_the_robots_and_do_not_follow_the_clock_when_it_is_set(
    monkeypatch, rtf, jump, received, stamps
):
    clocks = Clocks()
    monkeypatch.setattr(recorder, 'time', clocks)
    times = ArrivalTimes(rtf)
    clocks.system += 100 + jump
    clocks.steady += 100
    messages = [Received(1_000_000 + t if t else 0, None, b'') for t in received]

    assert [stamp - 1_000_000 for stamp, _ in times.of(messages)] == stamps
    assert messages == []
