import pytest

pytest.importorskip('rclpy')

from setcmas_expe.guard.surroundings import Base, base_of
from setcmas_simu.ros.cmd_vel_topics import Endpoint

BASE = Endpoint('turtlebot3_node', '/tb3_1/turtlebot3_node', 'twist', b'robot' + bytes(11))
ONLOOKER = Endpoint('ros2cli', '/ros2cli', 'twist_stamped', b'laptop' + bytes(10))
ROBOT = {BASE.participant}


@pytest.mark.parametrize(
    ('to_anybody', 'to_guard', 'robot', 'base'),
    [
        ([], [], ROBOT, Base()),
        ([], [BASE], ROBOT, Base(True, False, 'twist')),
        ([ONLOOKER], [BASE], ROBOT, Base(True, False, 'twist')),
        ([BASE], [ONLOOKER], ROBOT, Base(True, True, 'twist')),
        ([ONLOOKER], [BASE], set(), Base(True, True, 'twist_stamped')),  # who knows
    ],
)
def test_a_base_is_who_sends_odometry(to_anybody, to_guard, robot, base):
    assert base_of(to_anybody, to_guard, robot) == base
