import pytest

pytest.importorskip('rclpy')

import time

from rclpy.node import Node
from std_msgs.msg import Bool

from setcmas_ctrl.pause_watch import SURE_AFTER_S, EmergencyWatch
from setcmas_simu.ros import qos

TOPIC = '/emergency_stopped'


@pytest.mark.parametrize('looks_in_between', [True, False])
def test_a_held_stop_outlives_the_pause_node_that_held_it_though_another_says_go(
    peer, looks_in_between
):
    watch = EmergencyWatch(peer.node)
    nodes = [peer.add(Node(name, context=peer.context)) for name in ('holder', 'other')]
    holder, other = (node.create_publisher(Bool, TOPIC, qos.LATCHED) for node in nodes)
    peer.wait_for(lambda: peer.node.count_publishers(TOPIC) == 2)
    watch.take()
    holder.publish(Bool(data=True))
    if looks_in_between:
        peer.wait_for(watch.take)
    nodes[0].destroy_publisher(holder)
    peer.wait_for(lambda: peer.node.count_publishers(TOPIC) == 1)
    peer.wait_for(watch.take)

    def is_held_after(stopped):
        begin = time.monotonic()
        while time.monotonic() < begin + 2.0 * SURE_AFTER_S:
            other.publish(Bool(data=stopped))
            peer.spin(0.05)
            watch.take()
        return watch.stopped

    assert is_held_after(False)
    assert is_held_after(True)  # it takes the stop over
    assert not is_held_after(False)


def test_a_latched_stop_is_heard_by_who_comes_later_though_others_latch_none(peer):
    topic = '/emergency_stop'
    for is_stop in (True, False, False, False):
        peer.node.create_publisher(Bool, topic, qos.LATCHED).publish(Bool(data=is_stop))
    watch = EmergencyWatch(peer.node)
    heard = peer.listen(Bool, topic, qos.LATCHED_BY_MANY)
    peer.wait_for(lambda: len(heard) == 4)

    peer.wait_for(watch.take)


@pytest.mark.parametrize('profile', qos.FROM_ANYBODY, ids=['reliable', 'latched', 'best effort'])
def test_whoever_stops_the_robots_is_heard_whatever_the_quality_of_service(peer, profile):
    watch = EmergencyWatch(peer.node)
    stop = peer.node.create_publisher(Bool, '/emergency_stop', profile)

    def is_heard():
        stop.publish(Bool(data=True))
        return watch.take()

    peer.wait_for(is_heard)
