import itertools
import math
from pathlib import Path

import pytest
from processes import CTRL, SIMU

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile
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
from setcmas_simu.script_calls import Function

LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def test_states_are_sent_when_the_condition_triggers(start, peer, script):
    law = script('def control(robotNo, nbRobots, poses, t):\n    return 0.5, 0.0\n')
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    events = peer.listen(UInt16, '/tb3_1/trig_event')
    states = peer.listen(Odometry, '/tb3_1/trig_odom', LATCHED)
    start(*CTRL, '--algo', law, '--event-triggered', '--threshold', '0.3')

    def sent():  # each is repeated
        return sorted({position(state)[0] for state in states})

    peer.wait_for(lambda: len(sent()) > 4)

    x = sent()
    assert all(later - earlier > 0.3 for earlier, later in itertools.pairwise(x))
    peer.wait_for(lambda: {event.data for event in events} == {0, 1})
    late = peer.listen(Odometry, '/tb3_1/trig_odom', LATCHED)
    peer.wait_for(lambda: late)
    assert position(late[0])[0] <= x[-1]  # sent before it subscribed


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        (
            'def ctc(pos, last_pos, t):\n    while True:\n        pass\n',
            'tb3_1: ctc has not returned for 2 s; it is at when.py, line ',
        ),
        (
            'while True:\n    pass\ndef ctc(a, b, c):\n    return True\n',
            'tb3_1: when.py has been loading for',
        ),
    ],
    ids=['call', 'loading'],
)
def test_a_condition_that_hangs_is_located_and_ends_with_the_process(start, script, text, message):
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    options = ['--event-triggered', '--ctc', script(text, 'when.py')]
    process = start(*CTRL, '--algo', 'consensus', *options)
    process.wait_for_output(message)

    assert process.end() in (0, 1)
    assert 'Traceback' not in process.output()


class Sender:
    """Robot 3 with its node by itself, at 10 odometries a second."""

    def __init__(self, peer, condition):
        self.peer, self.stepped, self.said = peer, SteppedAlone(0.125), []
        of_node = self.stepped.arguments(peer, '-r', '__ns:=/tb3_3')
        self.node = EventTriggeredComm(None, False, **of_node)
        self.node.watch = CallWatch(self.said.append, connected_launcher({}))
        reports = ErrorReports(self.said.append, CONSEQUENCE, function=Function.CONDITION)
        self.node.broadcast = Broadcast(3, condition, Path('when.py'), reports)
        self.poses = FleetPoses({3: (self.node, self.node.odom_topic)}, 3)
        self.odometry = peer.publisher(Odometry, '/tb3_3/odom')
        self.states = peer.listen(Odometry, '/tb3_3/trig_odom', LATCHED)
        self.events = peer.listen(UInt16, '/tb3_3/trig_event')

    def at(self, x, seconds=0.125):
        """Let some time go by, and the robot be at x in m."""
        self.stepped.clock.t += seconds
        message = Odometry()
        message.pose.pose.position.x = x
        self.odometry.publish(message)
        self.poses.take(self.stepped.clock.t)
        if state := self.poses.new.get(3):
            self.node.evaluate(state)

    def heard(self):
        """Return the places that were sent, and the events."""
        self.peer.take_all()
        return [position(state)[0] for state in self.states], [one.data for one in self.events]


@pytest.fixture
def sender(peer):
    senders = []

    def create(condition):
        senders.append(Sender(peer, condition))
        return senders[-1]

    yield create
    for one in senders:
        one.node.watch.close()
        one.node.destroy_node()


def test_the_last_state_is_repeated_with_the_odometry_until_the_next_is_triggered(sender):
    robot = sender(further_than(0.25))
    for x in (0.0, 0.125, 0.25, 0.5, 0.625):
        robot.at(x)

    assert robot.heard() == ([0.0, 0.0, 0.0, 0.5, 0.5], [1, 0, 0, 1, 0])


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


def test_a_condition_that_fails_sends_each_state_and_is_named_once(sender):
    def fails(pos, last_pos, t):
        return 1 / 0

    robot = sender(fails)
    for x in (0.0, 0.125, 0.25):
        robot.at(x)

    assert robot.heard() == ([0.0, 0.125, 0.25], [1, 1, 1])
    assert len(robot.said) == 1
    assert 'ZeroDivisionError' in robot.said[0]
