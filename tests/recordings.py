"""A recorder under test, and what it left."""

import sys

import yaml
from rosbags.highlevel import AnyReader

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.bag_reader import open_bag

RECORDER = [sys.executable, '-m', 'setcmas_tools.bags.recorder']


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
