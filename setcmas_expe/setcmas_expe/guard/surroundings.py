"""Surroundings of a guard in the ROS graph: who commands its robot, and where its base listens."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from rclpy.node import Node

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.topics import CMD_VEL_TYPES
from setcmas_simu.ros import cmd_vel_topics
from setcmas_simu.ros.cmd_vel_topics import Endpoint


@dataclass(frozen=True)
class Base:
    """How the base of a robot receives commands.

    Attributes:
        is_there: Whether it listens at all.
        is_open: Whether it listens to cmd_vel directly.
        kind: Type of its messages.
    """

    is_there: bool = False
    is_open: bool = False
    kind: str = CMD_VEL_TYPES[0]


def base_of(
    to_cmd_vel: Collection[Endpoint], to_guard: Collection[Endpoint], robot: Collection[bytes]
) -> Base:
    """Return how a base listens; the base is the listener that sends odometry.

    Args:
        to_cmd_vel: Listeners to cmd_vel, except the guard.
        to_guard: Listeners to the guard's topic.
        robot: The processes that send the odometry of the wheels.
    """
    found = [*to_cmd_vel, *to_guard]
    base = [one for one in found if one.participant in robot] or found
    kinds = [kind for kind in CMD_VEL_TYPES if any(one.kind == kind for one in base)]
    is_open = any(one in to_cmd_vel for one in base)
    return Base(bool(kinds), is_open and bool(kinds), kinds[0] if kinds else CMD_VEL_TYPES[0])


class Surroundings:
    """Looks at the graph through the node of a guard.

    Attributes:
        cmd_vel: Full name of the topic of the bridge's commands.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.cmd_vel, self._guarded, self._odom = map(
            node.resolve_topic_name, (topics.CMD_VEL, topics.CMD_VEL_GUARDED, topics.ODOM)
        )
        self._own = cmd_vel_topics.own_participant(node)
        self._own_name = node.get_fully_qualified_name()

    def commanders(self) -> list[str]:
        """Return names of the other processes that publish commands.

        The pause node is ready to command zero in the bridge's place; it counts only if alone.
        """
        pause = cmd_vel_topics.participants(self._node, topics.PAUSED)
        others = cmd_vel_topics.strangers(self._node, self.cmd_vel, {self._own})
        return cmd_vel_topics.strangers(self._node, self.cmd_vel, {self._own, *pause}) or others

    def intruders(self) -> list[str]:
        """Return names of the others that publish to the base."""
        return cmd_vel_topics.strangers(self._node, self._guarded, {self._own})

    def base(self) -> Base:
        """Return how the robot's base listens."""
        to_cmd_vel = [
            one
            for one in cmd_vel_topics.listeners(self._node, self.cmd_vel)
            if (one.participant, one.full_name) != (self._own, self._own_name)
        ]
        to_guard = cmd_vel_topics.listeners(self._node, self._guarded)
        robot = cmd_vel_topics.participants(self._node, self._odom)
        return base_of(to_cmd_vel, to_guard, robot)
