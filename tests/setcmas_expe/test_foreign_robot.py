"""A robot that shares no code with this project, nor its DDS, plays the TurtleBot3."""

import sys
import time
from pathlib import Path

import pytest
from processes import SETCMAS, TIMEOUT_S

pytest.importorskip('rclpy')
pytest.importorskip('cyclonedds')

from std_msgs.msg import Bool

from setcmas_expe.pause.start_requests import REPEATS_WITHIN_S

ROBOT = Path(__file__).parent / 'scripts' / 'foreign_robot.py'
EXPE = [*SETCMAS, 'expe', '--algo', 'nav_wp', '--mocap', 'vrpn', '--no-joystick']


NIGHTLY = pytest.mark.nightly


@pytest.mark.parametrize('kind', ['TwistStamped', pytest.param('Twist', marks=NIGHTLY)])
def test_it_is_driven_with_the_type_that_it_listens_to(kind, start, peer, domain):
    robot = start(sys.executable, str(ROBOT), str(domain), kind)
    start(*EXPE)
    pause = peer.publisher(Bool, '/pause')
    deadline = time.monotonic() + TIMEOUT_S

    while 'goes' not in robot.output():  # wishes that come too early are refused
        assert time.monotonic() < deadline, 'the robot is not driven'
        pause.publish(Bool(data=False))
        peer.spin(1.1 * REPEATS_WITHIN_S)


def test_nothing_listens(start, domain):
    start(sys.executable, str(ROBOT), str(domain), 'nothing')
    expe = start(*EXPE)

    output = expe.wait_for_output('nothing listens to the commands of robot 1 (/tb3_1/cmd_vel)')
    assert 'bringup' in output
