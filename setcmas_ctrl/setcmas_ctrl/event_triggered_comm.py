"""Event-triggered communication: a node that sends the state of a robot when it is triggered."""

from __future__ import annotations

from typing import Any

from nav_msgs.msg import Odometry
from std_msgs.msg import UInt16

from setcmas_ctrl.communication.message_content import Value
from setcmas_ctrl.communication.triggering_conditions import Broadcast
from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_ctrl.scripts.call_watch import CallWatch
from setcmas_simu.fleet import topics
from setcmas_simu.reports.script_calls import Function
from setcmas_simu.robot_node import RobotNode
from setcmas_simu.ros import qos
from setcmas_simu.ros.messages import State


class EventTriggeredComm(RobotNode):
    """Publishes the state of robot i when its condition triggers: odom in, trig_odom out.

    The last state is repeated with each odometry, so that a lost message heals.

    Attributes:
        broadcast: Decides whether a state is sent.
    """

    def __init__(
        self, broadcast: Broadcast, poses: FleetPoses, watch: CallWatch, **of_node: Any
    ) -> None:
        """Listen to the odometry of a robot; `watch` times calls of its condition."""
        super().__init__('event_triggered_comm', broadcast.robot, **of_node)
        self.broadcast = broadcast
        self.watch = watch
        self.sent: Odometry | None = None
        self.trig_event = self.publisher(UInt16, topics.TRIG_EVENT, qos.EVENT)
        self.trig_odom = self.publisher(Odometry, topics.TRIG_ODOM, qos.LATCHED)
        poses.listen(self.robot, self.evaluate)

    def evaluate(self, state: State) -> None:
        """Decide whether to send a new state."""
        with self.watch.call(self.robot, self.broadcast.path, Function.CONDITION):
            triggered = self.broadcast.is_triggered(state.pose, state.V, self.time.t)
        self.trig_event.publish(UInt16(data=int(triggered)))
        if triggered:
            self.sent = state.odometry
        self.trig_odom.publish(self.sent)

    def carry(self, value: Value | None) -> None:
        """Take the value that the next states carry, for the condition."""
        self.broadcast.value = value
