import subprocess
import sys

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Point32

from setcmas_tools.page.live import LiveRun
from setcmas_tools.page.live_topics import LiveTopics


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
    code = 'import sys, setcmas_tools.page.viewer; print("matplotlib" in sys.modules)'
    found = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    assert found.stdout == 'False\n'
