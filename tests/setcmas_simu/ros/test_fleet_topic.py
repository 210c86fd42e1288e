import pytest

pytest.importorskip('rclpy')

import msgspec
from message_schemas import fits
from std_msgs.msg import String

from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_topic import Announcement, FleetAnnouncer, FleetListener

WHOLE = Announcement(3, (1, 2, 3), ('car', 'unicycle', 'car'), 'burger', 5.0, 1e9)
STRANGE = ('hello', '{}', '{"nb_robots":3}', '{"nb_robots":3,"robots":[0]}')


def encode(announcement):
    return msgspec.json.encode(announcement).decode()


def test_the_published_schema_describes_announcements_and_nothing_else():
    assert encode(Announcement(8, (1, 2))) == '{"nb_robots":8,"robots":[1,2]}'
    assert all(fits('fleet-1', encode(one)) for one in (WHOLE, Announcement(8, (1, 2))))
    assert not any(fits('fleet-1', text) for text in STRANGE)


@pytest.fixture
def listener(peer):
    return FleetListener(peer.node)


@pytest.fixture
def wait_for(peer, listener):
    """Wait until a condition holds of what the listener has taken."""

    def wait(condition):
        def holds():
            listener.take()
            return condition()

        peer.wait_for(holds)

    return wait


def test_the_lines_of_several_processes_make_up_a_fleet(peer, listener, wait_for):
    first, second = FleetAnnouncer(peer.node), FleetAnnouncer(peer.node)
    first.announce(Announcement(4, (1, 3), ('car', 'unicycle')))
    wait_for(lambda: listener.robots == [1, 3])
    assert listener.nb_robots == 4
    assert not listener.is_complete  # the other process has robots, too
    second.announce(Announcement(5, (2, 5), limits='burger', rtf=2.0, begin=1.0))

    wait_for(lambda: listener.robots == [1, 2, 3, 5])
    assert listener.is_complete
    assert listener.nb_robots == 5
    assert listener.models == {1: 'car', 3: 'unicycle'}


def test_a_simulator_that_starts_again_replaces_the_one_before(peer, listener, wait_for):
    FleetAnnouncer(peer.node).announce(Announcement(8, tuple(range(1, 9)), rtf=2.0))
    wait_for(lambda: listener.nb_robots == 8)
    again = FleetAnnouncer(peer.node)
    again.announce(Announcement(3, (1, 2, 3), limits='burger'))

    wait_for(lambda: listener.robots == [1, 2, 3])
    assert (listener.nb_robots, listener.first.rtf, listener.first.limits) == (3, 1.0, 'burger')


def test_robots_are_forgotten_when_nobody_announces_any(peer, listener, wait_for):
    publisher = peer.node.create_publisher(String, '/fleet', qos.LATCHED)
    publisher.publish(String(data=encode(Announcement(2, (1, 2)))))
    wait_for(lambda: listener.robots)
    peer.node.destroy_publisher(publisher)

    wait_for(lambda: not listener.robots)


def test_what_is_no_announcement_is_ignored_with_one_warning(peer, listener, wait_for, capfd):
    publisher = peer.node.create_publisher(String, '/fleet', qos.LATCHED_BY_MANY)
    for line in (*STRANGE, encode(WHOLE).replace('{', '{"colour":"red",', 1)):
        publisher.publish(String(data=line))

    wait_for(lambda: listener.announcements == [WHOLE])  # a later version may add fields
    assert capfd.readouterr().err.count('/fleet: a message is ignored') == 1
