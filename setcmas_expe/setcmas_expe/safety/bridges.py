"""Bridge process of an experiment: motion capture in, commands to real robots out.

Run as `ros2 run setcmas_expe bridges --lab lab.yaml`; `setcmas expe` does it for you.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Iterator

from geometry_msgs.msg import Point
from rclpy.node import Node
from visualization_msgs.msg import Marker, MarkerArray

from setcmas_ctrl.experiment_pause import (
    EmergencyWatch,
    PauseCause,
    PauseWatch,
)
from setcmas_expe.guard.machine_load import (
    OVERLOADED,
    ProcessorLoad,
    StallDetector,
    time_since_boot,
)
from setcmas_expe.guard.obedience import Runaways
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_options import LabOptions
from setcmas_expe.mocap.pose_track import mark_swapped
from setcmas_expe.mocap.receiver import MocapReceiver
from setcmas_expe.safety.bridge_decision import RATE_HZ, Decision, Situation, State, decide
from setcmas_expe.safety.bridge_reports import BridgeReports, RobotDiagnostics
from setcmas_expe.safety.motion_watch import MotionWatch
from setcmas_expe.safety.robot_bridges import CmdVelBridge, MocapBridge
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.announcement import Announcement
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros import qos
from setcmas_simu.ros.cmd_vel_topics import own_participant
from setcmas_simu.ros.fleet_topic import FleetAnnouncer
from setcmas_simu.ros.process import (
    FleetNode,
    RosProcess,
    node_main,
    prefer_this_process,
)
from setcmas_simu.ros.step_loop import StepLoop

_LINE_M = 0.03
_DISC_M = 0.005


def publish_arena(node: Node, lab: Lab) -> None:
    """Publish the arena's border and a disc around each robot, kept for late displays."""
    publisher = node.create_publisher(MarkerArray, topics.ARENA, qos.LATCHED)
    robots = [_separation(robot.number, lab.min_separation) for robot in lab.robots]
    publisher.publish(MarkerArray(markers=[_border(lab), *robots]))


def _border(lab: Lab) -> Marker:
    xmin, xmax, ymin, ymax = lab.arena
    corners = [(xmin, ymin), (xmax, ymin), (xmax, ymax), (xmin, ymax), (xmin, ymin)]
    marker = Marker(ns='arena', id=0, type=Marker.LINE_STRIP, action=Marker.ADD)
    marker.header.frame_id = topics.WORLD_FRAME
    marker.pose.orientation.w = 1.0
    marker.scale.x = _LINE_M
    marker.color.r, marker.color.a = 1.0, 1.0
    marker.points = [Point(x=x, y=y) for x, y in corners]
    return marker


def _separation(robot: int, diameter: float) -> Marker:
    # Robots are too close when their discs touch.
    marker = Marker(ns='separation', id=robot, type=Marker.CYLINDER, action=Marker.ADD)
    marker.header.frame_id = topics.robot_frame(robot)
    marker.frame_locked = True
    marker.pose.orientation.w = 1.0
    marker.scale.x = marker.scale.y = diameter
    marker.scale.z = _DISC_M
    marker.color.r, marker.color.g, marker.color.a = 1.0, 0.6, 0.4
    return marker


PAUSED, STOPPED = PauseCause.OPERATOR.value, PauseCause.EMERGENCY.value
_DIAGNOSTICS_EVERY = 4  # steps
_LOOK_AROUND_EVERY = 10  # steps
_LAST_ZEROS = 5
_ZERO = Decision(0.0, 0.0, State.STOPPED, '')


class SafetyStepper:
    """Sends every robot a command 20 times a second, zero whenever something is wrong."""

    def __init__(
        self,
        node: Node,
        lab: Lab,
        mocaps: list[MocapBridge],
        bridges: list[CmdVelBridge],
    ) -> None:
        """Take the bridges of each robot, in the same order; `node` is for the whole fleet.

        Nothing is sent before the first step.

        Raises:
            SetcmasError: The package of the messages of motion capture is not installed.
        """
        self._node = node
        self._lab = lab
        self._receiver = MocapReceiver(
            node, lab.mocap.source, lab.mocap.y_up, {mocap.body: mocap.take for mocap in mocaps}
        )
        self._robots = list(zip(mocaps, bridges, strict=True))
        self._emergency = EmergencyWatch(node)
        self._pause = PauseWatch(node, lab.timeouts.pause_s, latches=True)
        self._diagnostics = RobotDiagnostics(node)
        self._warn = node.get_logger().warning
        self._reports = BridgeReports(self._warn, self._robots)
        self._stalls = StallDetector(lab.timeouts.pause_s, time_since_boot())
        self._load = ProcessorLoad()
        self._pause_is_silent = False
        self._runaways = Runaways(lab.limits)
        robots = [mocap.robot for mocap in mocaps] if lab.checks_motion else []
        self._motion = MotionWatch(robots, self._warn, node.get_logger().info)
        if not lab.checks_motion:
            self._warn('the check that robots move as commanded is off')
        self._steps = 0
        self._stepped = -math.inf

    def stop(self) -> None:
        """Command zero at the end of the process, several times in case one is lost."""
        for _ in range(_LAST_ZEROS):
            for _, bridge in self._robots:
                bridge.send(_ZERO)
            time.sleep(1.0 / RATE_HZ)
        for _, bridge in self._robots:
            bridge.cmd_vel.wait_until_sent()

    def step(self, now: float) -> None:
        """Decide on new messages and command the robots; `now` is in s on the steady clock."""
        for _, bridge in self._robots:
            bridge.take(self._stepped, now)
        self._stepped = now
        if stalled_for := self._stalls.tick(time_since_boot()):
            # Messages that waited look new, and a person may have come near a robot.
            self._pause.forget()
            self._motion.end_proofs()
            self._warn(f'the bridge process stalled for {stalled_for:.1f} s: robots stay paused')
            if self._load.is_overload:
                self._warn(OVERLOADED)
        self._load.look(now)
        if self._steps % _LOOK_AROUND_EVERY == 0:
            self._look_around()
        paused = self._paused()
        decisions = {
            robot: decide(situation, self._lab)
            for robot, situation in self._situations(paused, now)
        }
        for mocap, bridge in self._robots:
            self._command(mocap, bridge, decisions[bridge.robot], now)
        commands = {robot: (one.V, one.omega) for robot, one in decisions.items()}
        self._motion.commanded({} if paused else commands, now)
        self._latch(decisions)
        self._reports.update(decisions, self._pause_is_silent, now)
        if self._steps % _DIAGNOSTICS_EVERY == 0:
            held = '' if paused == PAUSED else paused
            self._diagnostics.publish(self._robots, decisions, self._runaways.robots, held, now)
        self._steps += 1

    def _look_around(self) -> None:
        self._receiver.look_around()
        for mocap, bridge in self._robots:
            bridge.look_around()
            if mocap.reckoning and (news := mocap.reckoning.news()):
                self._warn(f'robot {mocap.robot} {news}, by wheel odometry')

    def _paused(self) -> str:
        """Return why all robots are paused; empty if they are not."""
        # A process that commands one robot past the checks may command them all.
        if contested := next((bridge for _, bridge in self._robots if bridge.rival), None):
            self._pause.latch(f'robot {contested.robot}: {contested.rival}')
        reason = self._pause.reason()
        self._pause_is_silent = reason is not None and reason.cause is PauseCause.SILENT
        if self._emergency.take():
            return STOPPED
        if reason is None or reason.is_of_operator:
            return reason.text if reason else ''
        return f'{PAUSED}: {reason.text}'

    def _situations(self, paused: str, now: float) -> Iterator[tuple[int, Situation]]:
        tracks = {mocap.robot: mocap.track for mocap, _ in self._robots}
        mark_swapped(tracks)
        self._motion.see(tracks, {bridge.robot: bridge.wheels for _, bridge in self._robots}, now)
        poses = {robot: track.pose for robot, track in tracks.items() if track.pose}
        unseen = tuple(robot for robot in tracks if robot not in poses)
        for mocap, bridge in self._robots:
            track = mocap.track
            V, omega = self._motion.allowed(bridge.robot, bridge.V, bridge.omega)
            trouble = self._receiver.trouble(mocap.body) or mocap.trouble
            yield (
                mocap.robot,
                Situation(
                    pose=track.pose,
                    pose_age=track.age(now),
                    pose_fault=trouble or self._motion.trouble(mocap.robot),
                    V=V,
                    omega=omega,
                    command_age=bridge.age(now),
                    paused=paused,
                    unseen=unseen,
                    rival=bridge.rival,
                    fault=bridge.fault,
                    others={robot: pose for robot, pose in poses.items() if robot != mocap.robot},
                ),
            )

    def _command(
        self, mocap: MocapBridge, bridge: CmdVelBridge, decision: Decision, now: float
    ) -> None:
        """Send a robot its command, and check that it stops."""
        bridge.send(decision)
        moving = decision.V != 0.0 or decision.omega != 0.0
        track = mocap.track
        track.note_command(moving, decision.state is State.PAUSED, now)
        # After a stall the last speed is too old to count.
        unknown = track.fault or track.age(now) > self._lab.timeouts.pose_s
        seen = (0.0, 0.0) if unknown else (mocap.speed, mocap.turn_rate)
        wheels, robots = bridge.rolls(now), self._runaways.robots
        if self._runaways.update(bridge.robot, not moving, seen, wheels, bool(bridge.rival), now):
            self._warn(
                f'robot {bridge.robot} still moves ({robots[bridge.robot]:.2f} m/s) despite zero '
                'commands: switch it off'
            )
        if bridge.robot in robots:
            bridge.cut_motors()

    def _latch(self, decisions: dict[int, Decision]) -> None:
        """Pause all robots until a person starts them, if a robot stopped for a lasting reason."""
        stopped = {robot: one.reason for robot, one in decisions.items() if one.lasting}
        if stopped:
            reason = next(iter(stopped.values()))
            robots = [robot for robot, why in stopped.items() if why == reason]
            each = ', each' if len(robots) > 1 else ''
            self._pause.latch(f'{robots_in_words(robots)}{each}: {reason}')


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
    announcer = FleetAnnouncer(node)
    mocaps = [MocapBridge(node, robot, lab) for robot in lab.robots]
    own = own_participant(node)
    bridges = [CmdVelBridge(node, robot, lab, own) for robot in lab.robots]
    process.add(node)
    publish_arena(node, lab)
    stepper = SafetyStepper(node, lab, mocaps, bridges)
    _greet(node, lab)
    try:
        robots = tuple(robot.number for robot in lab.robots)
        announcer.announce(Announcement(lab.nb_robots, robots))
        # Motion capture is called back in between: speeds need the times of arrival.
        StepLoop(process, 1.0 / RATE_HZ, stepper.step).run()
    finally:  # also after an error in a callback
        stepper.stop()


if __name__ == '__main__':
    sys.exit(main())
