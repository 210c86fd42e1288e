import pytest
from processes import CTRL

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from std_msgs.msg import String

from setcmas_simu.fleet.announcement import Announcement, encode
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


def test_an_announced_fleet_is_controlled_whole_however_slowly_it_is_discovered(
    start, peer, script
):
    publisher = peer.node.create_publisher(String, '/fleet', qos.LATCHED)
    publisher.publish(String(data=encode(Announcement(5, (1, 2, 3, 4, 5)))))
    SlowFleet(peer, 5)
    process = start(*CTRL, '--algo', script(STAND))

    peer.wait_for(lambda: 'controlling' in process.output())
    assert 'controlling robots 1-5' in process.output()


def test_a_fleet_that_nobody_announces_is_found_by_its_odometry(start, peer, script):
    SlowFleet(peer, 3)
    process = start(*CTRL, '--algo', script(STAND))

    peer.wait_for(lambda: 'controlling robots 1-3' in process.output())
    assert (
        process.output().count('robots 1-3 are found by odometry, and treated as unicycles') == 1
    )


@pytest.mark.nightly
@pytest.mark.parametrize('options', [(), ('--nb-robots', '2')])
def test_a_fleet_with_something_else_on_the_topic_is_found_too(start, peer, script, options):
    publisher = peer.node.create_publisher(String, '/fleet', qos.LATCHED)
    publisher.publish(String(data='hello'))
    SlowFleet(peer, 2)
    process = start(*CTRL, '--algo', script(STAND), *options)

    peer.wait_for(lambda: 'controlling robots 1-2' in process.output())
    assert process.output().count('/fleet: a message is ignored') == 1
    assert 'robots 1-2 are found by odometry' in process.output()
