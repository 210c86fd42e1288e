"""Nodes that broadcast a robot's state when its condition triggers (`--event-triggered`)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from nav_msgs.msg import Odometry
from std_msgs.msg import UInt16

from setcmas_ctrl.communication.communication_settings import Communication
from setcmas_ctrl.communication.triggering_conditions import CTC, Broadcast
from setcmas_ctrl.driving.odometry import FleetOdometry, State
from setcmas_ctrl.scripts.call_watch import CallWatch
from setcmas_ctrl.scripts.script_errors import ErrorReports
from setcmas_simu.fleet import topics
from setcmas_simu.reports.script_calls import Function
from setcmas_simu.ros import qos
from setcmas_simu.ros.messages import NO_STAMP, read_stamp
from setcmas_simu.ros.process import FleetNode


class EventTriggeredComm(FleetNode):
    """Broadcasts the state of one robot when its condition triggers, and publishes each decision.

    Attributes:
        sent: Stamp of the last state sent in ns; NO_STAMP if none was sent.
    """

    def __init__(
        self,
        broadcast: Broadcast,
        clock: Callable[[], float],
        watch: CallWatch,
        lockstep: bool = False,
    ) -> None:
        """Create the node; `clock` returns the time t of the run in s.

        In lockstep, late recorders still get everything.
        """
        super().__init__('event_triggered_comm', namespace=topics.robot_name(broadcast.robot))
        self.robot = broadcast.robot
        self.sent = NO_STAMP
        self._broadcast = broadcast
        self._now = clock
        self._watch = watch
        events, states = (qos.LOCKSTEP_STATE,) * 2 if lockstep else (qos.EVENT, qos.LATCHED)
        self._events = self.create_publisher(UInt16, topics.TRIG_EVENT, events)
        # Latched: late subscribers get the last state sent.
        self._states = self.create_publisher(Odometry, topics.TRIG_ODOM, states)

    def use(self, broadcast: Broadcast) -> None:
        """Use another condition, which sends its first state."""
        self._broadcast = broadcast

    def take(self, state: State) -> None:
        """Decide whether to send a state."""
        with self._watch.call(self.robot, self._broadcast.path, Function.CONDITION):
            triggered = self._broadcast.is_triggered(state.pose, state.V, self._now())
        self._events.publish(UInt16(data=int(triggered)))
        if triggered:
            self.sent = read_stamp(state.odometry)
            self._states.publish(state.odometry)


def broadcasters(
    robots: list[int],
    communication: Communication,
    odometry: FleetOdometry,
    reports: ErrorReports,
    clock: Callable[[], float],
    watch: CallWatch,
    lockstep: bool = False,
) -> list[EventTriggeredComm]:
    """Return a broadcasting node for each robot.

    Raises:
        SetcmasError: A triggering condition does not load.
    """
    nodes = []
    path = communication.condition_script or Path(CTC)
    for robot in robots:
        with watch.loading(robot, path):
            broadcast = communication.broadcast(robot, reports)
        node = EventTriggeredComm(broadcast, clock, watch, lockstep)
        odometry.listen(robot, node.take)
        nodes.append(node)
    return nodes
