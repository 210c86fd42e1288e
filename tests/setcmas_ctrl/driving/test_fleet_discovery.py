import os

import pytest
from processes import CTRL, SIMU

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from rclpy.qos import QoSProfile
from std_msgs.msg import Int32, String

from setcmas_simu.fleet.announcement import Announcement, Kind, Source, encode
from setcmas_simu.ros import qos

STAND = 'def control(i, n, p, t):\n    return 0, 0\n'


class SlowFleet:
    """Robots whose topics are discovered one after another, with pauses in between."""

    def __init__(self, peer, nb_robots):
        self.peer = peer
        self.robots = []
        self._nb_robots = nb_robots
        peer.node.create_timer(0.1, self._publish)
        peer.node.create_timer(0.7, self._add)

    def _add(self):
        if len(self.robots) < self._nb_robots:
            topic = f'/tb3_{len(self.robots) + 1}/odom'
            self.robots.append(self.peer.node.create_publisher(Odometry, topic, qos.STATE))

    def _publish(self):
        for robot in self.robots:
            robot.publish(Odometry())


def announce(peer, nb_robots, robots=None, process=1):
    robots = tuple(robots or range(1, nb_robots + 1))
    publisher = peer.node.create_publisher(String, '/fleet', qos.LATCHED)
    source = Source(Kind.SIMULATOR, 'peer', process)
    publisher.publish(String(data=encode(Announcement(nb_robots, robots, source))))
    return publisher


def test_an_announced_fleet_is_controlled_whole_however_slowly_it_is_discovered(
    start, peer, script
):
    announce(peer, 5)
    SlowFleet(peer, 5)
    process = start(*CTRL, '--algo', script(STAND))

    peer.wait_for(lambda: 'controlling' in process.output())
    assert 'controlling robots 1-5' in process.output()


VOLATILE = QoSProfile(depth=1)
STRANGE = {
    'JSON is malformed': (String(data='hello'), qos.LATCHED),
    'Invalid enum value 2': (
        String(data=encode(Announcement(2, (1, 2), Source(Kind.LAB, 'a', 1))).replace('1}', '2}')),
        qos.LATCHED,
    ),
    'a volatile publisher of std_msgs/msg/Int32': (Int32(), VOLATILE),
    'a volatile publisher of std_msgs/msg/String': (String(data='hello'), VOLATILE),
}


@pytest.mark.parametrize(
    ('reason', 'options'),
    [
        ('JSON is malformed', ()),
        *(
            pytest.param(reason, options, marks=pytest.mark.nightly)
            for reason in STRANGE
            for options in [(), ('--nb-robots', '2')]
        ),
    ],
)
def test_a_strange_announcement_is_reported_and_odometry_counts(
    start, peer, script, reason, options
):
    message, profile = STRANGE[reason]
    publisher = peer.node.create_publisher(type(message), '/fleet', profile)
    publisher.publish(message)
    SlowFleet(peer, 2)
    process = start(*CTRL, '--algo', script(STAND), *options)

    peer.wait_for(lambda: 'controlling robots 1-2' in process.output())
    assert process.output().count('ignored on /fleet: ') == 1
    assert reason in process.output()
    taken = 'using the robots that publish odometry: robots 1-2'
    assert options or taken in process.output()


@pytest.mark.nightly
def test_robots_that_are_not_announced_are_named_while_it_waits(start, peer, script):
    SlowFleet(peer, 2)
    process = start(*CTRL, '--algo', script(STAND))

    peer.wait_for(lambda: 'add --nb-robots; robots 1-2 publish odometry' in process.output())


def test_robots_that_are_announced_later_are_named(start, script):
    start(*SIMU, '--nb-robots', '2').wait_for_output('simulating')
    process = start(*CTRL, '--algo', script(STAND))
    process.wait_for_output('controlling robots 1-2')
    start(*SIMU, '--robots', '3-4')

    process.wait_for_output('robots 3-4 have appeared')


def test_a_controller_waits_for_its_own_simulator(start, peer, script):
    """As in a second `setcmas run` of one domain, whose simulator refuses to start."""
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    commands = peer.cmd_vel(1)
    waits = ('--nb-robots', '1', '--simulator', f'{os.getpid()}')
    process = start(*CTRL, '--algo', script(STAND), *waits)
    process.wait_for_output('waiting for the simulator')

    assert peer.node.count_publishers('/tb3_1/cmd_vel') == 0
    assert commands == []
    assert process.end() == 0
