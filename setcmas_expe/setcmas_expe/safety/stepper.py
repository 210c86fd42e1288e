"""Stepper of the bridge process: one step that decides every robot's command."""

from __future__ import annotations

import math
import time

from rclpy.node import Node

from setcmas_ctrl.fleet.pause_watch import SILENT, PauseWatch
from setcmas_expe.lab.model import Lab
from setcmas_expe.mocap.pose_track import mark_swapped
from setcmas_expe.mocap.receiver import MocapReceiver
from setcmas_expe.safety.cmd_vel_bridge import CmdVelBridge
from setcmas_expe.safety.decision import RATE_HZ, Decision, Situation, State, decide
from setcmas_expe.safety.mocap_bridge import MocapBridge
from setcmas_expe.safety.reporting.diagnostics import RobotDiagnostics
from setcmas_expe.safety.reporting.reports import BridgeReports
from setcmas_expe.safety.runaways import Runaways
from setcmas_expe.safety.stalls import StallDetector, time_since_boot
from setcmas_simu.fleet.topics import robot_name

_DIAGNOSTICS_EVERY = 4  # steps
_LOOK_AROUND_EVERY = 10  # steps
_LAST_ZEROS = 5
_ZERO = Decision(0.0, 0.0, State.STOPPED, '')


class SafetyStepper:
    """Sends every robot a command 20 times a second, zero whenever something is wrong."""

    def __init__(
        self, node: Node, lab: Lab, mocaps: list[MocapBridge], bridges: list[CmdVelBridge]
    ) -> None:
        """Prepare; nothing is sent before the first step.

        Args:
            node: The node that owns what concerns the whole fleet.
            lab: The rules.
            mocaps: The mocap bridge of each robot.
            bridges: The cmd_vel bridge of each robot, in the same order.

        Raises:
            SetcmasError: The package of the messages of motion capture is not installed.
        """
        self._node = node
        self._lab = lab
        self._receiver = MocapReceiver(
            node, lab.mocap.source, lab.mocap.y_up, {mocap.body: mocap.take for mocap in mocaps}
        )
        self._robots = list(zip(mocaps, bridges, strict=True))
        self._pause = PauseWatch(node, lab.timeouts.pause_s, latches=True)
        self._diagnostics = RobotDiagnostics(node)
        self._warn = node.get_logger().warning
        self._reports = BridgeReports(self._warn, self._robots)
        self._stalls = StallDetector(lab.timeouts.pause_s, time_since_boot())
        self._runaways = Runaways()
        self._steps = 0
        self._stepped = -math.inf

    def stop(self) -> None:
        """Command zero, several times in case one is lost; called while the process ends."""
        for _ in range(_LAST_ZEROS):
            for _, bridge in self._robots:
                bridge.send(_ZERO)
            time.sleep(1.0 / RATE_HZ)
        for _, bridge in self._robots:
            bridge.cmd_vel.wait_until_sent()

    def step(self, now: float) -> None:
        """Decide on what has come, and command the robots; `now` is in s on the steady clock."""
        for _, bridge in self._robots:
            bridge.take(self._stepped)
        self._stepped = now
        if stalled_for := self._stalls.tick(time_since_boot()):
            # Messages that waited meanwhile look new, and somebody may have come near a robot.
            self._pause.forget()
            self._warn(
                f'the bridge process was held up for {stalled_for:.1f} s: robots stay paused'
            )
        if self._steps % _LOOK_AROUND_EVERY == 0:
            self._receiver.look_around()
            for _, bridge in self._robots:
                bridge.look_around()
        tracks = {mocap.robot: mocap.track for mocap, _ in self._robots}
        mark_swapped(tracks)
        poses = {robot: track.pose for robot, track in tracks.items() if track.pose}
        unseen = tuple(robot for robot in tracks if robot not in poses)
        # Whoever commands one robot past the checks may command them all.
        if contested := next((bridge for _, bridge in self._robots if bridge.rival), None):
            self._pause.hold(f'{robot_name(contested.robot)}: {contested.rival}')
        paused = self._pause.reason()
        decisions = {}
        for mocap, bridge in self._robots:
            situation = Situation(
                pose=mocap.track.pose,
                pose_age=mocap.track.age(now),
                pose_fault=self._receiver.trouble(mocap.body) or mocap.track.trouble,
                V=bridge.V,
                omega=bridge.omega,
                command_age=bridge.age(now),
                paused=paused,
                unseen=unseen,
                rival=bridge.rival,
                others={robot: pose for robot, pose in poses.items() if robot != mocap.robot},
            )
            decision = decisions[mocap.robot] = decide(situation, self._lab)
            bridge.send(decision)
            moving = decision.V != 0.0 or decision.omega != 0.0
            mocap.track.note_command(moving, decision.state is State.PAUSED, now)
            rival = bool(bridge.rival)
            if self._runaways.update(bridge.robot, not moving, mocap.speed, rival, now):
                self._warn(
                    f'{robot_name(bridge.robot)} still moves ({abs(mocap.speed):.2f} m/s), '
                    'although it is commanded zero: switch it off'
                )
        self._reports.update(decisions, paused == SILENT, now)
        if self._steps % _DIAGNOSTICS_EVERY == 0:
            self._diagnostics.publish(self._robots, decisions, self._runaways.robots, now)
        self._steps += 1
