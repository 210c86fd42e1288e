"""The bridges of an experiment: motion capture in, commands to real robots out.

Run as `ros2 run setcmas_expe bridges --lab lab.yaml`; `setcmas expe` does it for you.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Point
from visualization_msgs.msg import Marker, MarkerArray

from setcmas_ctrl.pause_reason import PauseCause, PauseReason
from setcmas_ctrl.pause_watch import EmergencyWatch, PauseWatch
from setcmas_expe.bridge.bridge_decision import RATE_HZ, Decision, FleetView, RobotView, StopReason
from setcmas_expe.bridge.machine_load import StallDetector, time_since_boot, warn_of_load
from setcmas_expe.bridge.motion_watch import MotionWatch
from setcmas_expe.cmd_vel_bridge import CmdVelBridge
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_file import LabOptions
from setcmas_expe.mocap_bridge import MocapBridge
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.robot_node import StepTime, run_steps
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.fleet_topic import Announcement, FleetAnnouncer
from setcmas_simu.ros.messages import wait_until_received
from setcmas_simu.ros.polling import RequestWait
from setcmas_simu.ros.process import RosProcess, node_main, prefer_this_process

_REPORT_EVERY = 4  # steps
_LAST_ZEROS = 5
_LINE_M = 0.03


class Bridges:
    """Steps the bridges of a lab 20 times a second.

    Attributes:
        mocap: Publishes the poses of the robots.
        bridges: Send each robot its commands.
        fleet: Judges all robots together.
    """

    def __init__(self, node: FleetNode, lab: Lab) -> None:
        """Create the nodes of a lab; `node` stands for the fleet. Nothing is sent before a step.

        Raises:
            SetcmasError: The package of the messages of motion capture is not installed.
        """
        if not lab.guarded:
            node.get_logger().warning(
                'without guards, robots keep their last velocity if this computer or the network '
                'dies'
            )
        self.time = StepTime(1.0 / RATE_HZ)
        self.mocap = MocapBridge(lab, node)
        self.bridges = [CmdVelBridge(robot, lab, node, self.time) for robot in lab.robots]
        self.fleet = BridgedFleet(node, lab)
        self._diagnostics = node.create_publisher(DiagnosticArray, topics.DIAGNOSTICS, qos.STATE)
        self._steps = 0

    def step(self) -> None:
        """Decide on new messages and command the robots."""
        now = self.time.now
        self.mocap.step(now)
        views = {bridge.robot: bridge.look() for bridge in self.bridges}
        fleet = self.fleet.judge(views, now)
        decisions = {bridge.robot: bridge.command(fleet) for bridge in self.bridges}
        self.fleet.note(decisions, now)
        if self._steps % _REPORT_EVERY == 0:
            reports = [bridge.report(decisions[bridge.robot]) for bridge in self.bridges]
            message = DiagnosticArray(status=reports)
            message.header.stamp = self.time.stamp
            self._diagnostics.publish(message)
        self._steps += 1

    def stop(self) -> None:
        """Command zero at the end of the process, several times in case one is lost."""
        for _ in range(_LAST_ZEROS):
            for bridge in self.bridges:
                bridge.stop()
            time.sleep(1.0 / RATE_HZ)
        wait_until_received(bridge.cmd_vel.publisher for bridge in self.bridges)


class BridgedFleet:
    """Judges all robots of a lab together, and pauses them all if one stops for good.

    It has what their bridges share: the pause, where robots are, who has proved itself.
    """

    def __init__(self, node: FleetNode, lab: Lab) -> None:
        """Listen to the pause and the stop through the node of the process."""
        self.warn = node.get_logger().warning
        self._pause = PauseWatch(node, lab.timeouts.pause_s, latches=True)
        self._emergency = EmergencyWatch(node)
        self._was_silent = True
        self._stalls = StallDetector(lab.timeouts.pause_s, time_since_boot())
        robots = [robot.number for robot in lab.robots] if lab.checks_motion else []
        self._motion = MotionWatch(robots, self.warn, node.get_logger().info)
        if not lab.checks_motion:
            self.warn('the check that robots move as commanded is off')

    def judge(self, views: Mapping[int, RobotView], now: float) -> FleetView:
        """Return what each bridge must know, from what each knows of its robot, by number."""
        self._look_for_stalls()
        pause = self._pause_reason()
        self._motion.see(views, now)
        allowed = {
            robot: self._motion.proving.allowed(robot, *view.wanted)
            for robot, view in views.items()
        }
        return FleetView(pause, views, allowed, self._motion.deviations())

    def note(self, decisions: Mapping[int, Decision], now: float) -> None:
        """Note the decisions of a step: a robot that stopped for good pauses all of them."""
        is_paused = any(one.pause for one in decisions.values())
        commands = {robot: (one.V, one.omega) for robot, one in decisions.items()}
        self._motion.commanded({} if is_paused else commands, now)
        lasting: dict[StopReason, list[int]] = {}
        for robot, decision in decisions.items():
            if decision.why and decision.why.cause.lasts and not decision.pause:
                lasting.setdefault(decision.why, []).append(robot)
        if lasting:
            why, robots = next(iter(lasting.items()))
            each = ', each' if len(robots) > 1 else ''
            self._pause.latch(f'{robots_in_words(robots)}{each}: {why.text}')
            if why.cause.may_be_load:
                warn_of_load(self.warn)

    def _look_for_stalls(self) -> None:
        if stalled_for := self._stalls.tick(time_since_boot()):
            # Messages that waited look new, and a person may have come near a robot.
            self._pause.forget()
            self._motion.end_proofs()
            self.warn(f'the bridge process stalled for {stalled_for:.1f} s: robots stay paused')
            warn_of_load(self.warn)

    def _pause_reason(self) -> PauseReason | None:
        pause = self._pause.reason()
        is_silent = pause is not None and pause.cause is PauseCause.SILENT
        if is_silent and not self._was_silent:  # who else would say it?
            self.warn('all robots stopped: the pause node is silent')
            warn_of_load(self.warn)
        self._was_silent = is_silent
        if self._emergency.take():
            return PauseReason(PauseCause.EMERGENCY, PauseCause.EMERGENCY.value)
        return pause


def publish_arena(node: FleetNode, lab: Lab) -> None:
    """Publish the arena's border, kept for late displays."""
    xmin, xmax, ymin, ymax = lab.arena
    corners = [(xmin, ymin), (xmax, ymin), (xmax, ymax), (xmin, ymax), (xmin, ymin)]
    marker = Marker(ns='arena', id=0, type=Marker.LINE_STRIP, action=Marker.ADD)
    marker.header.frame_id = topics.WORLD_FRAME
    marker.pose.orientation.w = 1.0
    marker.scale.x = _LINE_M
    marker.color.r, marker.color.a = 1.0, 1.0
    marker.points = [Point(x=x, y=y) for x, y in corners]
    publisher = node.create_publisher(MarkerArray, topics.ARENA, qos.LATCHED)
    publisher.publish(MarkerArray(markers=[marker]))


def _greet(node: FleetNode, lab: Lab) -> None:
    robots = robots_in_words([robot.number for robot in lab.robots])
    arena, source = lab.arena, lab.mocap.topic_of(lab.robots[0])
    node.get_logger().info(
        f'bridging {robots}: poses from {source} ({lab.mocap.preset}), '
        f'arena {arena.xmin:g} to {arena.xmax:g} by {arena.ymin:g} to {arena.ymax:g} m, '
        f'up to {lab.limits.V_max:.2f} m/s'
    )


def main(argv: list[str] | None = None) -> int:
    """Bridge until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='bridges', description=__doc__)
    LabOptions.add_to(parser)
    prefer_this_process()
    return node_main(parser, _bridge, argv)


def _bridge(process: RosProcess, args: argparse.Namespace) -> None:
    lab = LabOptions.of(args).chosen()
    node = FleetNode(topics.BRIDGES_NODE)
    # First: whoever discovers the topics of the robots has then found it.
    announcer = FleetAnnouncer(node)
    bridges = Bridges(node, lab)
    publish_arena(node, lab)
    # Poses are taken when they come: speeds need the times of arrival.
    nodes = [node, bridges.mocap, *bridges.bridges]
    process.requests = RequestWait(nodes, bridges.mocap.receiver.polled)
    _greet(node, lab)
    try:
        robots = tuple(robot.number for robot in lab.robots)
        announcer.announce(Announcement(lab.nb_robots, robots))
        run_steps(process, bridges.time, bridges.step)
    finally:  # also after an error in a step
        bridges.stop()


if __name__ == '__main__':
    sys.exit(main())
