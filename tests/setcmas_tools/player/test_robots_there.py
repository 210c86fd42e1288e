import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import String

from setcmas_simu.fleet.fleet import Announcement, Kind, encode, own_source
from setcmas_simu.ros import qos
from setcmas_tools.player.robots_there import RobotsThere

PLAYED = ['/tb3_1/odom', '/tb3_2/odom', '/fleet']


@pytest.fixture
def there(peer):
    return RobotsThere(peer.node, PLAYED)


def test_nobody_has_them(there, peer):
    peer.node.create_publisher(Odometry, '/tb3_3/odom', 1)

    assert there.before() == ''


def test_somebody_has_announced_them(there, peer):
    announcement = Announcement(8, (2, 3), own_source(Kind.SIMULATOR))
    publisher = peer.node.create_publisher(String, '/fleet', qos.LATCHED)
    publisher.publish(String(data=encode(announcement)))

    peer.wait_for(there.before)
    assert there.before().startswith('robot 2 is there already: a simulator (process ')


def test_somebody_publishes_one_of_their_topics(there, peer):
    peer.node.create_publisher(Odometry, '/tb3_2/odom', 1)

    peer.wait_for(there.before)
    assert there.before() == 'somebody else publishes /tb3_2/odom'
    assert there.beside() == ''  # one publisher is the player itself


def test_a_robot_listens_to_commands(there, peer):
    peer.node.create_subscription(TwistStamped, '/tb3_1/cmd_vel', lambda _: None, 1)

    peer.wait_for(there.beside)
    assert there.beside() == 'tb3_1 is there already: /peer listens to /tb3_1/cmd_vel'
