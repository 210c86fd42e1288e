"""The mocap bridge: a node that passes on the poses of motion capture that can be trusted.

`setcmas expe` has it in one process with the cmd_vel bridges (`bridges.py`).
"""

from __future__ import annotations

import time
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from nav_msgs.msg import Odometry

from setcmas_ctrl.pause_watch import PauseWatch
from setcmas_expe.guard.guard_watch import diagnostic_status
from setcmas_expe.lab.lab import Lab, LabRobot
from setcmas_expe.mocap.dead_reckoning import DeadReckoning
from setcmas_expe.mocap.pose_judge import TOO_SLOW_HZ, PoseJudge, VelocityFilter
from setcmas_expe.mocap.receiver import MocapReceiver
from setcmas_expe.mocap.sources import Sample
from setcmas_simu.fleet import topics
from setcmas_simu.ros import messages, qos
from setcmas_simu.ros.fleet_node import FleetNode, of_other_nodes

_LOOK_EVERY_S = 0.5


class TrackedRobot:
    """A robot as motion capture sees it.

    Attributes:
        number: Its number.
        track: Its poses, and which of them to trust.
        reckoning: Places poses that count from the start; None if they do not.
        velocities: Estimates its forward speed and turn rate.
        odom: Publishes its poses.
        state: Publishes why poses are rejected, and its body's height in m.
    """

    def __init__(self, node: FleetNode, robot: LabRobot, lab: Lab) -> None:
        self.number, self.body = robot.number, robot.mocap_name
        start = robot.start if lab.mocap.source.from_start else None
        self.reckoning = DeadReckoning(start) if start else None
        # Wheel odometry knows nothing of a robot that is carried, or that counts from 0 again.
        may_be_carried = lab.checks_motion and not start
        self.track = PoseJudge(lab.arena, lab.limits, may_be_carried)
        self.velocities = VelocityFilter()
        odom, state = topics.mocap_topic(robot.number), topics.pose_state_topic(robot.number)
        self.odom = node.create_publisher(Odometry, odom, qos.STATE)
        self.state = node.create_publisher(DiagnosticStatus, state, qos.STATE)
        self.message = Odometry(child_frame_id=topics.robot_frame(robot.number))
        self.message.header.frame_id = topics.WORLD_FRAME


class MocapBridge(FleetNode):
    """Judges the poses of all robots: the driver's topics in, /mocap/tb3_i/odom out.

    Controller, SiToUni and CmdVelBridge of robot i read the latter.
    /mocap/tb3_i/pose_state says why poses are rejected. It listens to /paused, because a person
    may carry robots in a pause.

    Attributes:
        robots: The robots.
        receiver: Listens to the driver, and finds conflicts between senders.
    """

    def __init__(self, lab: Lab, fleet: FleetNode) -> None:
        """Create the topics of the robots of a lab; `fleet` stands for this process.

        Raises:
            SetcmasError: The package of the messages of motion capture is not installed.
        """
        of_fleet: dict[str, Any] = {'namespace': fleet.fleet_namespace or '/'} | of_other_nodes()
        super().__init__(topics.MOCAP_BRIDGE, start_parameter_services=False, **of_fleet)
        self.robots = [TrackedRobot(self, robot, lab) for robot in lab.robots]
        takers = {robot.body: partial(self.take, robot) for robot in self.robots}
        self.receiver = MocapReceiver(self, lab.mocap.source, lab.mocap.y_up, takers)
        self.pause = PauseWatch(self, lab.timeouts.pause_s)
        self.is_paused = True
        self._next_look = 0.0

    def take(self, robot: TrackedRobot, sample: Sample) -> None:
        """Judge a measurement (Z-up) that has just come, and publish it if it is good."""
        now = time.monotonic()
        if robot.reckoning:
            sample = robot.reckoning.placed(sample, now)
        if not robot.track.take(sample, now, self.is_paused):
            return
        V, omega = robot.velocities.update(sample, now)
        out = robot.message
        # When it was measured, by this machine's clock: a recording has one time.
        age_ns = round(1e9 * (now - robot.track.measured))
        out.header.stamp = messages.stamp_of(time.time_ns() - age_ns)
        messages.fill_odometry(out, sample.planar(), V, omega)
        robot.odom.publish(out)

    def step(self, now: float) -> None:
        """Publish the state of the poses of each robot; `now` is in s on a steady clock.

        Between steps, the process takes poses as they come; a step takes those that still wait.
        """
        self.receiver.take()
        self.is_paused = self.pause.reason() is not None
        if now >= self._next_look:
            self._next_look = now + _LOOK_EVERY_S
            self.receiver.look_around()
        for robot in self.robots:
            robot.state.publish(self.state_of(robot))

    def state_of(self, robot: TrackedRobot) -> DiagnosticStatus:
        """Return why poses of a robot are rejected, as a message; OK without text if not."""
        track = robot.track
        trouble = self.receiver.trouble(robot.body) or track.trouble
        if robot.reckoning:
            trouble = trouble or robot.reckoning.trouble
        if track.rate < TOO_SLOW_HZ:
            least = f'it must send at least {TOO_SLOW_HZ:g}'
            trouble = trouble or f'motion capture sends {track.rate:.1f} poses a second; {least}'
        level = DiagnosticStatus.ERROR if trouble else DiagnosticStatus.OK
        values = {'height': '' if track.height is None else f'{track.height:.3f}'}
        name = topics.robot_name(robot.number)
        return diagnostic_status(level, name, trouble, robot.odom.topic_name, values)
