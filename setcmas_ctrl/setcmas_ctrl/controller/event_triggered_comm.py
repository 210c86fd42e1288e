"""Broadcasts of a robot's state when its condition triggers (`--event-triggered`)."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from nav_msgs.msg import Odometry
from rclpy.node import Node
from std_msgs.msg import UInt16

from setcmas_ctrl.communication.communication_settings import Communication
from setcmas_ctrl.communication.message_content import Value
from setcmas_ctrl.communication.triggering_conditions import CTC, Broadcast
from setcmas_ctrl.driving.odometry import FleetOdometry, State
from setcmas_ctrl.scripts.call_watch import CallWatch
from setcmas_ctrl.scripts.script_errors import ErrorReports
from setcmas_simu.fleet import topics
from setcmas_simu.reports.script_calls import Function
from setcmas_simu.ros import qos
from setcmas_simu.ros.messages import NO_STAMP, read_stamp

_REPEAT_EVERY_NS = 90_000_000  # 10 Hz; odometry comes a little early or late


class EventTriggeredComm:
    """Broadcasts the state of one robot when its condition triggers, and publishes each decision.

    It repeats the last state sent at 10 Hz, so that receivers that missed it get it all the same.

    Attributes:
        sent: Stamp of the last state sent in ns; NO_STAMP if none was sent.
    """

    def __init__(
        self,
        node: Node,
        broadcast: Broadcast,
        clock: Callable[[], float],
        watch: CallWatch,
        lockstep: bool = False,
    ) -> None:
        """Create the topics; `clock` returns the time t of the run in s.

        In lockstep, late recorders still get everything.
        """
        self.robot = broadcast.robot
        self.sent = NO_STAMP
        self._last_sent = b''  # encoded
        self._published = NO_STAMP
        self._broadcast = broadcast
        self._now = clock
        self._watch = watch
        events, states = (qos.LOCKSTEP_STATE,) * 2 if lockstep else (qos.EVENT, qos.LATCHED)
        topic = partial(topics.robot_topic, self.robot)
        self._events = node.create_publisher(UInt16, topic(topics.TRIG_EVENT), events)
        # Latched: late subscribers get the last state sent.
        self._states = node.create_publisher(Odometry, topic(topics.TRIG_ODOM), states)

    def use(self, broadcast: Broadcast) -> None:
        """Use another condition, which sends its first state."""
        self._broadcast = broadcast

    def carry(self, value: Value | None) -> None:
        """Take the value that the next states carry, for the condition."""
        self._broadcast.value = value

    def take(self, state: State) -> None:
        """Decide whether to send a state."""
        with self._watch.call(self.robot, self._broadcast.path, Function.CONDITION):
            triggered = self._broadcast.is_triggered(state.pose, state.V, self._now())
        self._events.publish(UInt16(data=int(triggered)))
        stamp = read_stamp(state.odometry)
        if triggered:
            self.sent, self._last_sent = stamp, state.odometry
        if triggered or abs(stamp - self._published) >= _REPEAT_EVERY_NS:
            self._published = stamp
            self._states.publish(self._last_sent)


def broadcasters(
    node: Node,
    robots: list[int],
    communication: Communication,
    odometry: FleetOdometry,
    reports: ErrorReports,
    clock: Callable[[], float],
    watch: CallWatch,
    lockstep: bool = False,
) -> list[EventTriggeredComm]:
    """Return a broadcaster for each robot.

    Raises:
        SetcmasError: A triggering condition does not load.
    """
    found = []
    path = communication.condition_script or Path(CTC)
    for robot in robots:
        with watch.loading(robot, path):
            broadcast = communication.broadcast(robot, reports)
        found.append(EventTriggeredComm(node, broadcast, clock, watch, lockstep))
        odometry.listen(robot, found[-1].take)
    return found
