import pytest
from processes import CTRL

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from std_msgs.msg import String

from setcmas_simu.ros import qos


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


@pytest.mark.parametrize('text', ['', pytest.param('hello', marks=pytest.mark.nightly)])
def test_a_fleet_that_nobody_announces_is_found_by_its_odometry(start, peer, script, text):
    if text:  # something else is on the topic of announcements
        peer.node.create_publisher(String, '/fleet', qos.LATCHED).publish(String(data=text))
    SlowFleet(peer, 3)
    process = start(*CTRL, '--algo', script('def control(i, n, p, t):\n    return 0, 0\n'))

    peer.wait_for(lambda: 'controlling robots 1-3' in process.output())
    assert (
        process.output().count('robots 1-3 are found by odometry, and treated as unicycles') == 1
    )
