"""Guard on a robot's own computer: it stops the robot when its commands end.

A TurtleBot3 keeps its last velocity when whatever commanded it, or the network, dies. Run as
`ros2 run setcmas_expe cmd_vel_guard --ros-args -r __ns:=/tb3_1`; no topic need be remapped.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription

from setcmas_expe.safety.stop_on_silence import SILENCE_S, StopOnSilence
from setcmas_simu.cmd_vel import cmd_vel_graph
from setcmas_simu.cmd_vel.cmd_vel_type import TYPES, velocities
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.topics import AUTO, CMD_VEL_TYPES
from setcmas_simu.options.group import Options, option
from setcmas_simu.options.kinds import Number, OneOf
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main

_RATE_HZ = 20.0
_LOOK_EVERY_S = 1.0
_LAST_WORDS_S = 0.3


@dataclass(frozen=True, kw_only=True)
class GuardOptions(Options):
    """What a guard listens to, and when it stops its robot."""

    cmd_vel_type: str = option(
        OneOf((AUTO, *CMD_VEL_TYPES)),
        'message type of cmd_vel',
        default=AUTO,
        default_text=f'{AUTO}, what the robot listens to',
    )
    silence: float = option(
        Number(above=0, unit='s', finite=True),
        'silence from which the robot is stopped',
        default=SILENCE_S,
    )


class CmdVelGuard(FleetNode):
    """Listens to cmd_vel of its namespace, in the type that the robot takes."""

    def __init__(
        self,
        cmd_vel_type: str = AUTO,
        silence_s: float = SILENCE_S,
        namespace: str | None = None,
    ) -> None:
        """Create the node.

        Args:
            cmd_vel_type: 'twist', 'twist_stamped', or 'auto' for what the robot listens to.
            silence_s: Silence from which the robot is stopped, in s.
            namespace: The robot's; the one that `--ros-args` gives by default.
        """
        super().__init__(topics.CMD_VEL_GUARD_NODE, namespace=namespace)
        self._silence_s = silence_s
        self._kind = ''
        self._was_commanded = False
        self._subscription: Subscription | None = None
        self._publisher: Publisher
        self._topic = self.resolve_topic_name(topics.CMD_VEL)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        # Runs only while there is something to watch: a Raspberry Pi has other things to do.
        self._timer = self.create_timer(1.0 / _RATE_HZ, self._watch, clock=steady)
        self._timer.cancel()
        if cmd_vel_type == AUTO:
            self.create_timer(_LOOK_EVERY_S, self._follow_robot, clock=steady)
            self._follow_robot()
        else:
            self._use(cmd_vel_type)

    def stop(self) -> None:
        """Stop the robot, whatever was heard of its commands; called while the process ends.

        A command may have reached the robot and not yet the guard.
        """
        if self._kind:
            self._publish_zero()
            self._publisher.wait_for_all_acked(Duration(seconds=_LAST_WORDS_S))

    def _follow_robot(self) -> None:
        """Use the type that the robot takes, found out as by those who command it."""
        found = cmd_vel_graph.listeners(self, self._topic)
        odometry = self.resolve_topic_name(topics.ODOM)
        kinds = cmd_vel_graph.types_of_robot(self, found, odometry)
        if kinds and self._kind not in kinds:
            self._use(next(kind for kind in CMD_VEL_TYPES if kind in kinds))

    def _use(self, kind: str) -> None:
        if self._subscription:
            self.destroy_subscription(self._subscription)
            self.destroy_publisher(self._publisher)
        self._kind = kind
        self._publisher = self.create_publisher(TYPES[kind], topics.CMD_VEL, qos.COMMAND)
        self._subscription = self.create_subscription(
            TYPES[kind],
            topics.CMD_VEL,
            self._on_cmd_vel,
            qos.COMMAND,
        )
        # The robot may be moving, and whoever commanded it dead: nobody can ask it.
        self._logic = StopOnSilence(time.monotonic(), self._silence_s)
        self._was_commanded = False
        self._timer.reset()
        self.get_logger().info(f'guarding {self._topic} ({kind})')

    def _on_cmd_vel(self, message: Twist | TwistStamped) -> None:
        self._logic.hear(*velocities(message), time.monotonic())
        if self._logic.moving:
            self._was_commanded = True
            if self._timer.is_canceled():
                self._timer.reset()

    def _watch(self) -> None:
        moving = self._logic.moving
        if self._logic.must_stop(time.monotonic()):
            self._publish_zero()
            if moving and self._was_commanded:
                self.get_logger().warning('commands have ended: stopping the robot')
        elif not moving:
            self._timer.cancel()

    def _publish_zero(self) -> None:
        self._publisher.publish(TYPES[self._kind]())


def main(argv: list[str] | None = None) -> int:
    """Guard until a signal arrives; returns the exit status."""
    parser = argparse.ArgumentParser(prog='cmd_vel_guard', description=__doc__)
    GuardOptions.add_to(parser)
    return node_main(parser, _guard, argv)


def _guard(process: RosProcess, args: argparse.Namespace) -> None:
    options = GuardOptions.of(args)
    guard = CmdVelGuard(options.cmd_vel_type, options.silence)
    process.add(guard)
    try:
        process.spin()
    finally:
        guard.stop()


if __name__ == '__main__':
    sys.exit(main())
