"""Communication network, for control scripts: `from setcmas_ctrl import network`.

    def control(robotNo, nbRobots, poses, t):
        for j in network.neighbours():            # robots whose states this robot receives
            weight = network.adjacency()[robotNo - 1, j - 1]
        network.send({'x': 1.0, 'goal': [2, 3]})  # to whoever receives this robot's state
        for sender, message in network.received().items():
            message.value['x'], message.age

The answers are for the robot whose `control` is running, at the current time. Delay, loss and
noise of the links are in `communication/delay_and_loss.py`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Protocol

from setcmas_ctrl.communication import graph as communication_graph
from setcmas_ctrl.communication.message_content import (
    Content,
    Message,
    Value,
    checked_value,
    read_only,
)
from setcmas_simu.arrays import Floats


class Exchange(Protocol):
    """Carries messages between the robots of a run."""

    @property
    def t(self) -> float:
        """Time of the current call in s."""

    def begin(self) -> None:
        """Prepare for messages: a law uses them.

        Raises:
            RuntimeError: There can be none in this run.
        """

    def send(self, robot: int, value: Value) -> None:
        """Let the next states that a robot sends carry a value."""

    def received(self, robot: int) -> Mapping[int, Content]:
        """Return what a robot has received last, by the numbers of the senders."""


# All robots of a process share this module.
_call: LawCall | None = None  # the present one
_exchange: Exchange | None = None


class LawCall:
    """A call of a control law: inside, its script may ask this module, and send a value."""

    def __init__(self, robot: int, adjacency: Floats) -> None:
        """Take the robot of the law, and the adjacency matrix (N, N), read-only."""
        self.robot, self.adjacency = robot, adjacency
        self.outgoing: Value | None = None

    def __enter__(self) -> None:
        global _call
        self._before, _call = _call, self  # a law may call another one

    def __exit__(self, *_: object) -> None:
        global _call
        _call = self._before
        if self.outgoing is not None and _exchange:
            _exchange.send(self.robot, self.outgoing)


def _present_call() -> LawCall:
    if _call is None:
        raise RuntimeError(
            'network works only while setcmas calls control; '
            'to try a function alone: from setcmas_tools import simulate'
        )
    return _call


def neighbours() -> list[int]:
    """Return the numbers of the robots whose states this robot receives, sorted.

    Raises:
        RuntimeError: Called outside `control`.
    """
    call = _present_call()
    return communication_graph.neighbours(call.adjacency, call.robot)


def adjacency() -> Floats:
    """Return the adjacency matrix: [i - 1, j - 1] is the weight that i gives j, 0 without a link.

    Returns:
        A read-only array of shape (nbRobots, nbRobots).

    Raises:
        RuntimeError: Called outside `control`.
    """
    return _present_call().adjacency


def laplacian() -> Floats:
    """Return the Laplacian of the graph, diag(sum_j a_ij) - A, shape (nbRobots, nbRobots).

    Raises:
        RuntimeError: Called outside `control`.
    """
    return communication_graph.laplacian(adjacency())


def send(value: Any) -> None:
    """Send a value with the states that this robot sends from now on, until the next value.

    Robots that receive such a state have the value from their next call on. In one call the last
    value counts.

    Args:
        value: A finite number, an array with up to 2 dimensions, or a flat dict of names to
            these; at most 64 numbers and 16 names.

    Raises:
        RuntimeError: Called outside `control`.
        TypeError, ValueError: It cannot be sent.
    """
    call = _present_call()
    if _exchange:
        _exchange.begin()
    call.outgoing = checked_value(value)


def received() -> dict[int, Message]:
    """Return the last message from each robot, by its number; none from robots never received.

    Raises:
        RuntimeError: Called outside `control`.
    """
    call = _present_call()
    if not _exchange:
        return {}
    _exchange.begin()
    t = _exchange.t
    return {
        sender: Message(read_only(content.value), round(t - content.t, 9), content.t)
        for sender, content in sorted(_exchange.received(call.robot).items())
    }


@contextmanager
def exchanged_by(exchange: Exchange | None) -> Iterator[None]:
    """Let an exchange carry the messages of all laws inside; None carries none."""
    global _exchange
    before, _exchange = _exchange, exchange
    try:
        yield
    finally:
        _exchange = before


def contents() -> dict[int, Content]:
    """Return what this robot has received last, by sender, for callers in whose place others ask.

    Raises:
        RuntimeError: Called outside `control`.
    """
    call = _present_call()
    return dict(_exchange.received(call.robot)) if _exchange else {}
