"""A kind of fault: how it begins and ends, which robots must stop, which line must report it."""

from __future__ import annotations

import enum
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rehearsal import Rehearsal, Stop

Outcome = list[Stop]


class Place(enum.Enum):
    """Where robots and motion capture of a rehearsal are."""

    EMULATED = 'children of setcmas expe'
    APART = 'processes of their own'
    NETWORK = 'on another machine'


def nothing(_: Rehearsal) -> None:
    """Undo nothing: the fault ends by itself, or has ended the experiment."""


def all_stop(r: Rehearsal, fault: float) -> Outcome:
    """Wait until every robot has stopped."""
    return [r.wait_for_stop(fault, robot) for robot in r.truth]


@dataclass(frozen=True)
class Kind:
    """A kind of fault.

    Attributes:
        inject: Brings it about; returns when, in s since 1970.
        line: A regular expression of the line that reports it.
        undo: Takes its cause away, after the stop.
        stops: Waits for the stops of those that must stop.
        lets_go: Whether robots may go on by themselves (arena, separation).
        options: Of `setcmas expe`.
        place: Where robots and motion capture are.
        moving: Whether robots move already; else the fault is there when they are started, and
            they are judged by how far they roll.
    """

    inject: Callable[[Rehearsal], float]
    line: str
    undo: Callable[[Rehearsal], None] = nothing
    stops: Callable[[Rehearsal, float], Outcome] = all_stop
    lets_go: bool = False
    options: tuple[str, ...] = ()
    place: Place = Place.EMULATED
    moving: bool = True


def sends(r: Rehearsal, topic: str, message: Any, rate: float = 20.0, qos: Any = 10) -> float:
    """Have another node send a message again and again; return since when."""
    publisher = r.peer.node.create_publisher(type(message), topic, qos)
    r.peer.node.create_timer(1.0 / rate, lambda: publisher.publish(_stamped(r, message)))
    r.others.append(publisher)
    return time.time()


def falls_silent(r: Rehearsal) -> None:
    """Remove all publishers of other nodes."""
    for timer in list(r.peer.node.timers):
        r.peer.node.destroy_timer(timer)
    for publisher in r.others:
        r.peer.node.destroy_publisher(publisher)
    r.others.clear()


def _stamped(r: Rehearsal, message: Any) -> Any:
    if hasattr(message, 'header') and message.header.frame_id != 'old':
        message.header.stamp = r.peer.node.get_clock().now().to_msg()
    return message
