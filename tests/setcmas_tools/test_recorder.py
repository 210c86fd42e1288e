import signal
import sys
import time

import pytest
import yaml

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bag_reader import open_bag

pytest.importorskip('rclpy')

from geometry_msgs.msg import Point32, Twist
from nav_msgs.msg import Goals
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.highlevel import AnyReader
from std_msgs.msg import String, UInt16
from stereo_msgs.msg import DisparityImage

RECORDER = [sys.executable, '-m', 'setcmas_tools.nodes.recorder']
LATCHED = QoSProfile(depth=20, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=20, reliability=ReliabilityPolicy.BEST_EFFORT)


@pytest.fixture
def bag(tmp_path):
    return tmp_path / 'bag'


@pytest.fixture
def record(start, peer, bag):
    """A function that starts a recorder and waits until its bag exists."""

    def record(*arguments, **options):
        recorder = start(*RECORDER, '-o', str(bag), *arguments, **options)
        peer.wait_for(lambda: bag.exists())
        return recorder

    return record


def recorded(bag, topic):
    """Return the messages of a topic in a bag that was closed well."""
    with AnyReader([bag]) as reader:
        connections = [c for c in reader.connections if c.topic == topic]
        if not connections:
            return []
        return [reader.deserialize(d, c.msgtype) for c, _, d in reader.messages(connections)]


def offered(bag, topic):
    metadata = yaml.safe_load((bag / 'metadata.yaml').read_text())
    topics = metadata['rosbag2_bagfile_information']['topics_with_message_count']
    (found,) = (t['topic_metadata'] for t in topics if t['topic_metadata']['name'] == topic)
    return found['offered_qos_profiles']


def wait_until_on_disk(peer, bag, topic, count=1):
    """Wait until so many messages of a topic can be read from the bag that is being recorded."""

    def is_on_disk():
        try:
            with open_bag(bag) as opened:
                return sum(t.name == topic for t, _, _ in opened.messages()) >= count
        except SetcmasError:
            return False

    peer.wait_for(is_on_disk)


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
    assert recorded(bag, '/parameter_events') == []
    assert recorder.output().count('recording ') == 1
    assert 'recorded 101 messages of 2 topics in ' in recorder.output()


def test_times_in_the_bag_do_not_go_back(record, peer, bag):
    recorder = record()
    publishers = [peer.publisher(UInt16, f'/topic_{i}', qos=100) for i in range(3)]
    for i in range(60):
        publishers[i % 3].publish(UInt16(data=i))
        time.sleep(0.003)
    for i in range(3):
        wait_until_on_disk(peer, bag, f'/topic_{i}', 20)
    recorder.end()

    with AnyReader([bag]) as reader:
        messages = list(reader.messages([c for c in reader.connections if 'topic_' in c.topic]))
    times = [time_ns for _, time_ns, _ in messages]
    order = [int.from_bytes(data[4:6], 'little') for _, _, data in messages]
    assert len(times) == 60
    assert times == sorted(times)
    assert order == sorted(order)


@pytest.mark.parametrize('signum', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_close_the_bag(record, peer, bag, signum):
    recorder = record()
    publisher = peer.publisher(UInt16, '/number')
    publisher.publish(UInt16(data=7))
    wait_until_on_disk(peer, bag, '/number')

    assert recorder.end(signum) == 0
    assert [message.data for message in recorded(bag, '/number')] == [7]


def test_kill_leaves_what_was_recorded(record, peer, bag):
    recorder = record()
    publisher = peer.publisher(UInt16, '/number')

    def is_on_disk():
        publisher.publish(UInt16(data=7))
        try:
            with open_bag(bag) as opened:
                return len(list(opened.messages())) > 3
        except SetcmasError:
            return False

    peer.wait_for(is_on_disk)
    recorder.end(signal.SIGKILL)

    assert not (bag / 'metadata.yaml').exists()
    with open_bag(bag) as opened:
        values = [topic.type.decode(data).data for topic, _, data in opened.messages()]
    assert values
    assert set(values) == {7}


def test_message_from_before_the_recorder(record, peer, bag):
    latched = peer.node.create_publisher(UInt16, '/latched', LATCHED)
    for i in range(5):
        latched.publish(UInt16(data=i))
    recorder = record()
    wait_until_on_disk(peer, bag, '/latched', 5)
    recorder.end()

    assert [message.data for message in recorded(bag, '/latched')] == list(range(5))
    assert offered(bag, '/latched')[0]['durability'] == 'transient_local'


def test_publishers_that_guarantee_nothing(record, peer, bag):
    recorder = record()
    publisher = peer.publisher(UInt16, '/number', qos=BEST_EFFORT)
    publisher.publish(UInt16(data=7))
    wait_until_on_disk(peer, bag, '/number')
    recorder.end()

    assert [message.data for message in recorded(bag, '/number')] == [7]
    assert offered(bag, '/number')[0]['reliability'] == 'best_effort'


def test_first_message_of_a_publisher_that_somebody_waits_for(record, peer, bag):
    recorder = record()
    for topic in ('/command', '/latched'):
        peer.listen(UInt16, topic)
        peer.wait_for(lambda topic=topic: peer.node.count_subscribers(topic) == 2)
    command = peer.publisher(UInt16, '/command', listeners=2)
    command.publish(UInt16(data=1))
    latched = peer.publisher(UInt16, '/latched', listeners=2, qos=LATCHED)
    for i in range(10):
        latched.publish(UInt16(data=i))
    peer.wait_for(
        lambda: any(
            info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
            for info in peer.node.get_subscriptions_info_by_topic('/latched')
        )
    )
    marker = peer.publisher(UInt16, '/marker')
    marker.publish(UInt16())
    for topic, count in (('/command', 1), ('/latched', 10), ('/marker', 1)):
        wait_until_on_disk(peer, bag, topic, count)
    recorder.end()

    assert [message.data for message in recorded(bag, '/command')] == [1]
    assert [message.data for message in recorded(bag, '/latched')] == list(range(10))


def test_a_publisher_of_another_type_than_expected(record, start, peer, bag):
    recorder = record()
    peer.listen(Twist, '/tb3_1/cmd_vel')
    peer.wait_for(lambda: peer.node.count_subscribers('/tb3_1/cmd_vel') == 2)
    # Of a node in another participant: one participant has one type for a name.
    code = (
        'import rclpy; from geometry_msgs.msg import TwistStamped; rclpy.init()\n'
        'node = rclpy.create_node("other")\n'
        'publisher = node.create_publisher(TwistStamped, "/tb3_1/cmd_vel", 10)\n'
        'while not publisher.get_subscription_count(): rclpy.spin_once(node, timeout_sec=0.05)\n'
        'message = TwistStamped(); message.twist.linear.x = 0.25\n'
        'publisher.publish(message)\n'
        'print("published"); rclpy.spin(node)\n'
    )
    start(sys.executable, '-c', code).wait_for_output('published')
    wait_until_on_disk(peer, bag, '/tb3_1/cmd_vel')
    recorder.end()

    (message,) = recorded(bag, '/tb3_1/cmd_vel')
    assert message.__msgtype__ == 'geometry_msgs/msg/TwistStamped'
    assert message.twist.linear.x == 0.25


def test_type_that_only_its_package_knows(record, peer, bag):
    recorder = record()
    publisher = peer.publisher(Goals, '/goals')
    publisher.publish(Goals())
    wait_until_on_disk(peer, bag, '/goals')
    recorder.end()

    assert len(recorded(bag, '/goals')) == 1
    (info,) = peer.node.get_publishers_info_by_topic('/goals')
    with AnyReader([bag]) as reader:
        (connection,) = (c for c in reader.connections if c.topic == '/goals')
    assert connection.digest == str(info.topic_type_hash)


def test_type_without_a_python_package_is_told_once(record, peer, bag, tmp_path):
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


def test_chosen_topics_only(record, peer, bag):
    recorder = record('--topics', 'wanted', '/parameter_events', '/missing')
    wanted = peer.publisher(UInt16, '/wanted')
    unwanted = peer.node.create_publisher(UInt16, '/unwanted', 10)
    unwanted.publish(UInt16())
    wanted.publish(UInt16(data=7))
    wait_until_on_disk(peer, bag, '/wanted')
    assert unwanted.get_subscription_count() == 0
    recorder.end()

    assert [message.data for message in recorded(bag, '/wanted')] == [7]
    assert '/missing was never published' in recorder.output()
    assert '/wanted was never published' not in recorder.output()


def test_an_empty_recording_is_closed_well(record, bag):
    recorder = record()

    assert recorder.end() == 0
    assert f'nothing was recorded: no message came; {bag} is an empty bag' in recorder.output()
    with AnyReader([bag]) as reader:
        assert reader.message_count == 0


def test_a_full_disk_gets_one_line_and_leaves_what_was_written(start, peer, bag):
    # A limit on the size of files: the same OSError as that of a full disk, without a disk.
    code = (
        'import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (2**21,) * 2)\n'
        'from setcmas_tools.nodes.recorder import main; sys.exit(main())\n'
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
        f"error: recording to '{bag}' stopped: File too large; what was written before is readable"
    ]
    assert 'Traceback' not in recorder.output()
    with open_bag(bag) as opened:
        texts = [topic.type.decode(data).data for topic, _, data in opened.messages()]
    assert texts
    assert set(texts) == {message.data}


def test_a_bag_that_exists_is_not_touched(start, domain, bag):
    bag.mkdir()
    recorder = start(*RECORDER, '-o', str(bag))

    assert recorder.wait() == 2
    assert recorder.output() == (
        f"error: '{bag}' exists already; accepted is a folder that does not\n"
    )
    assert list(bag.iterdir()) == []
