"""Answers of a recorder to a simulator in lockstep: how far all odometry has come."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node

from setcmas_simu.fleet import topics
from setcmas_simu.ros.messages import read_stamp
from setcmas_simu.simulator.lockstep import NONE
from setcmas_simu.simulator.lockstep_topics import Answerer
from setcmas_tools.recorder.recorded_topic import Received


class LockstepAnswers:
    """Tells the simulator which state of every robot has come; it does not run away then."""

    def __init__(self, node: Node, robots: Sequence[int]) -> None:
        """Answer through a node for odometry of robots."""
        self._answerer = Answerer(node)
        self._stamps = {topics.odometry_topic(robot): NONE for robot in robots}
        self._answered = NONE

    def take(self, received: Sequence[Received]) -> None:
        """Look at what has come."""
        for message in received:
            if message.topic.name in self._stamps:
                self._stamps[message.topic.name] = read_stamp(message.data)
        oldest = min(self._stamps.values())
        if oldest != self._answered:
            self._answered = oldest
            self._answerer.answer(oldest)

    def leave(self) -> None:
        """Tell the simulator not to wait any more."""
        self._answerer.leave()
