import math
from functools import partial
from pathlib import Path

import pytest

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from ros_peer import position
from std_msgs.msg import UInt16
from stepped_alone import SteppedAlone

from setcmas_ctrl.communication.triggering_conditions import CONSEQUENCE, Broadcast, further_than
from setcmas_ctrl.event_triggered_comm import EventTriggeredComm
from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_ctrl.laws.call_watch import CallWatch
from setcmas_ctrl.laws.script_errors import ErrorReports
from setcmas_simu.reports import connected_launcher
from setcmas_simu.ros import qos
from setcmas_simu.script_calls import Function


class Sender:
    """Robot 3 with its node by itself, at 10 odometries a second."""

    def __init__(self, peer, condition):
        self.peer, self.stepped, self.said = peer, SteppedAlone(0.125), []
        of_node = self.stepped.arguments(peer, '-r', '__ns:=/tb3_3')
        self.node = peer.add(EventTriggeredComm(None, False, **of_node))
        self.node.watch = CallWatch(self.said.append, connected_launcher({}))
        peer.ends.callback(self.node.watch.close)
        reports = ErrorReports(self.said.append, CONSEQUENCE, function=Function.CONDITION)
        self.node.broadcast = Broadcast(3, condition, Path('when.py'), reports)
        self.poses = FleetPoses({3: (self.node, self.node.odom_topic)}, 3)
        self.odometry = peer.publisher(Odometry, '/tb3_3/odom')
        self.states = peer.listen(Odometry, '/tb3_3/trig_odom', qos.LATCHED_BY_MANY)
        self.events = peer.listen(UInt16, '/tb3_3/trig_event')

    def at(self, x, seconds=0.125):
        """Let some time go by, and the robot be at x in m."""
        self.stepped.clock.t += seconds
        message = Odometry()
        message.pose.pose.position.x = x
        self.odometry.publish(message)
        self.poses.take(self.stepped.clock.t)
        if state := self.poses.new.get(3):
            self.node.evaluate(state, self.poses.odometry[3])

    def heard(self):
        """Return the places that were sent, and the events."""
        self.peer.take_all()
        return [position(state)[0] for state in self.states], [one.data for one in self.events]


@pytest.fixture
def sender(peer):
    return partial(Sender, peer)


def test_the_last_state_is_repeated_with_the_odometry_until_the_next_is_triggered(sender):
    robot = sender(further_than(0.25))
    for x in (0.0, 0.125, 0.25, 0.5, 0.625):
        robot.at(x)

    assert robot.heard() == ([0.0, 0.0, 0.0, 0.5, 0.5], [1, 0, 0, 1, 0])
    late = robot.peer.listen(Odometry, '/tb3_3/trig_odom', qos.LATCHED_BY_MANY)
    robot.peer.wait_for(lambda: late)
    assert position(late[-1])[0] == 0.5  # sent before it subscribed


def test_it_is_repeated_at_10_hz_at_most_but_each_event_is_sent_at_once(sender):
    robot = sender(further_than(0.25))
    for x in (0.0, 0.125, 0.125, 0.125, 0.5, 0.5):
        robot.at(x, 0.03125)

    assert robot.heard() == ([0.0, 0.0, 0.5], [1, 0, 0, 0, 1, 0])


def test_odometry_that_cannot_be_used_is_left_out(sender):
    robot = sender(further_than(0.25))
    robot.at(0.0)
    robot.at(math.nan)
    robot.odometry.publish(serialize_message(Odometry())[:50])
    robot.at(0.5)

    assert robot.heard() == ([0.0, 0.5], [1, 1])
