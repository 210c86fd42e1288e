"""Faults of an emulated lab, and the message that injects one."""

from __future__ import annotations

import enum
import os
from dataclasses import dataclass

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics


class FaultKind(enum.Enum):
    """What goes wrong; the values are texts for people."""

    DROPOUT = 'motion capture sends nothing for the robot'
    NAN = 'motion capture sends values that are not numbers'
    FROZEN = 'motion capture repeats the last pose'
    JUMP = 'motion capture sees the robot 1 m away from its place'
    SWAP = 'motion capture swaps the names of this robot and the next'
    LATE = 'its poses arrive 1 s late'
    PUSH = 'a person pushes the robot out of the arena'
    DRIFT = 'its poses drift away at 0.3 m/s'
    LIFT = 'a person lifts the robot by 15 cm; its wheels turn in the air'
    FALLEN = 'its markers have fallen off'
    MIRRORED = 'the y axis of its poses points the other way'
    TURNED = 'its markers are turned by 90 degrees'
    BLOCKED = 'a person holds the robot while its wheels turn'
    STALLED = 'its wheels do not turn'
    OFF = 'the robot is switched off, then switched on again'
    UNGUARDED = 'its cmd_vel_guard hangs'
    DEAF = 'its base ignores new commands and keeps following the last one: pause to see it'
    PERSON = (
        'a person steps in front of it; its lidar stops it if lidar_stop is true in the lab file'
    )

    @property
    def word(self) -> str:
        """Its name in messages and on the command line."""
        return self.name.lower()


PURPOSES = {kind.word: kind.value for kind in FaultKind}
"""What happens in each fault, by its word."""

DEFAULT_S = 3.0
"""Default duration of a fault in s."""


@dataclass(frozen=True)
class Fault:
    """A fault of a robot, or of its poses, for a duration in s."""

    kind: FaultKind
    robot: int
    duration: float = DEFAULT_S

    def __str__(self) -> str:
        """Return the text that `parse_fault` reads."""
        return f'{self.kind.word} {self.robot} {self.duration:g}'


def parse_fault(text: str) -> Fault:
    """Return the fault in a text such as 'dropout 2 3.0', or raise SetcmasError."""
    try:
        kind, robot, seconds = text.split()
        return Fault(FaultKind[kind.upper()], int(robot), float(seconds))
    except (KeyError, ValueError):
        raise SetcmasError(
            f"fault '{text}' is not understood; it must be 'KIND ROBOT SECONDS' with one of "
            f'{", ".join(PURPOSES)}'
        ) from None


_DISCOVERY_S = 3.0
_SENDING_S = 2.0


def inject(fault: Fault) -> None:
    """Send a fault to the emulated lab in this ROS domain, or raise SetcmasError."""
    from rclpy.duration import Duration
    from std_msgs.msg import String

    from setcmas_simu.ros import qos
    from setcmas_simu.ros.fleet_node import FleetNode
    from setcmas_simu.ros.process import ros_process

    with ros_process() as process:
        node = FleetNode('inject_fault')
        process.add(node)
        publisher = node.create_publisher(String, topics.EMULATED_FAULT, qos.EVENT)
        if not process.spin_until(lambda: publisher.get_subscription_count() > 0, _DISCOVERY_S):
            raise SetcmasError(
                f'there is no emulated lab in ROS domain {os.environ.get("ROS_DOMAIN_ID", "0")}: '
                'start one with setcmas expe --emulate'
            )
        publisher.publish(String(data=str(fault)))
        publisher.wait_for_all_acked(Duration(seconds=_SENDING_S))
