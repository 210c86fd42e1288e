import math
import subprocess
import sys

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Point, Point32
from visualization_msgs.msg import Marker

from setcmas_tools.page.live_run import LiveRun
from setcmas_tools.page.live_topics import LiveTopics, planar_shape


@pytest.fixture
def state():
    return LiveRun(0.0)


@pytest.fixture
def viewed(peer, state):
    topics = LiveTopics(peer.node, state)
    topics.look()
    return topics


def begins(peer, viewed, state):
    """Wait until the run has begun for the page."""

    def is_running():
        viewed.take(1.0)
        return state.clock.describe(1.0) == 'running'

    peer.wait_for(is_running)


def test_a_robot_with_another_number_may_be_the_only_one_that_is_commanded(peer, viewed, state):
    state.see(3, (0.0, 0.0, 0.0), 0.0, 1.0)
    publisher = peer.publisher(Point32, '/tb3_3/cmd_cart_vel', listeners=0)
    peer.wait_for(lambda: peer.node.count_publishers('/tb3_3/cmd_cart_vel'))
    viewed.look()
    peer.wait_for(publisher.get_subscription_count)
    publisher.publish(Point32())

    begins(peer, viewed, state)


def test_the_process_of_a_live_page_needs_no_matplotlib():
    """It took 27 MB of the 70 that the process has."""
    code = 'import sys, setcmas_tools.page.live_page; print("matplotlib" in sys.modules)'
    found = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    assert found.stdout == 'False\n'


def marker(kind, points=(), **fields):
    message = Marker(type=kind, **fields)
    message.pose.position.x, message.pose.position.y = 2.0, 3.0
    message.scale.x = message.scale.y = 0.4
    message.color.r = message.color.a = 1.0
    message.points = [Point(x=float(x), y=float(y)) for x, y in points]
    return message


@pytest.mark.parametrize('kind', [Marker.SPHERE, Marker.CYLINDER])
def test_a_disc(kind):
    assert planar_shape(marker(kind)) == {
        'kind': 'discs',
        'places': [[2.0, 3.0]],
        'size': 0.4,
        'colour': '#ff0000',
        'alpha': 1.0,
    }


def test_an_outline():
    found = planar_shape(marker(Marker.LINE_STRIP, [(0, 0), (1, 0), (1, 2)]))

    assert (found['kind'], found['places']) == ('lines', [[0, 0, 1, 0], [1, 0, 1, 2]])


@pytest.mark.parametrize('wrong', [math.nan, math.inf])
def test_markers_without_a_finite_place_and_of_other_kinds_are_not_shown(wrong):
    message = marker(Marker.SPHERE)
    message.pose.position.x = wrong

    assert planar_shape(message) is None
    assert planar_shape(marker(Marker.LINE_STRIP)) is None
    assert planar_shape(marker(Marker.LINE_STRIP, [(0, 0), (1, wrong)])) is None
    assert planar_shape(marker(Marker.CUBE)) is None
