"""Event-triggered communication: a node that sends the state of a robot when it is triggered."""

from __future__ import annotations

import math
from typing import Any

from nav_msgs.msg import Odometry
from std_msgs.msg import UInt16

from setcmas_ctrl.communication.triggering_conditions import Broadcast
from setcmas_ctrl.laws.call_watch import CallWatch
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet import topics
from setcmas_simu.robot_node import RobotNode
from setcmas_simu.ros import qos
from setcmas_simu.ros.messages import RobotState
from setcmas_simu.script_calls import Function

_REPEAT_S = 0.09  # 10 Hz; odometry comes a little early or late


class EventTriggeredComm(RobotNode):
    """Publishes the state of robot i when its condition triggers: odom in, trig_odom out.

    It repeats the last state at 10 Hz, for receivers that missed it.
    It has no `step`: its process (`ControlledFleet`) calls `evaluate` with each new odometry.

    Attributes:
        broadcast: The triggering condition, with what it remembers.
        watch: Times the calls of the condition.
        odom_topic: The topic of the robot's poses.
        sent: The last state sent, a serialised odometry.
        published: When trig_odom was last published, in s.
    """

    broadcast: Broadcast
    watch: CallWatch

    def __init__(self, robot: int | None, in_experiment: bool, **of_node: Any) -> None:
        """Create the topics of a robot; `of_node` is for `RobotNode`."""
        super().__init__('event_triggered_comm', robot, **of_node)
        odom = topics.mocap_topic(self.robot) if in_experiment else topics.ODOM
        self.odom_topic = self.fixed('odom_topic', odom, 'poses of the robot')
        self.trig_event = self.create_publisher(UInt16, topics.TRIG_EVENT, qos.EVENT)
        self.trig_odom = self.create_publisher(Odometry, topics.TRIG_ODOM, qos.LATCHED)
        self.sent: bytes | None = None
        self.published = -math.inf

    def see(self, known: Floats, poses: Floats, adjacency: Floats | None) -> None:
        """Take the poses (3, N) of the fleet, as known to the robot and as they are.

        The condition may use those of neighbours in the adjacency matrix, if there are links.
        """
        if adjacency is not None:
            self.broadcast.see(known, poses, adjacency[self.robot - 1])

    def evaluate(self, state: RobotState, odometry: bytes) -> None:
        """Decide whether to send a new state of the robot; otherwise repeat the last one.

        The odometry is the serialised message that the state was read from, and that is sent.
        """
        with self.watch.call(self.robot, self.broadcast.path, Function.CONDITION):
            triggered = self.broadcast.is_triggered(state.pose, state.V, self.time.t)
        self.trig_event.publish(UInt16(data=int(triggered)))
        now = self.time.clock.now()
        if triggered:
            self.sent = odometry
        elif now - self.published < _REPEAT_S:
            return
        self.published = now
        self.trig_odom.publish(self.sent)
