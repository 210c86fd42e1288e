"""Lockstep: simulated time that advances when all followers have answered."""

from __future__ import annotations

import os
import reprlib
import uuid
from array import array
from collections.abc import Sequence
from typing import NamedTuple

from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.topics import MAX_ROBOTS
from setcmas_simu.ros import messages
from setcmas_simu.ros.messages import NO_STAMP

_FIRST_NS = 10**9  # stamp of t = 0: ROS and readers of bags take 0 for "no time"


class Ticks:
    """Clock that moves from tick to tick on command; messages of this process carry its time.

    Attributes:
        rate: Rate of the ticks in Hz.
        count: Number of the current tick, from 0.
        time: The time in s; it may be set forward between two ticks.
    """

    def __init__(self, rate: float) -> None:
        self.rate = rate
        self.count = 0
        self.time = 0.0
        messages.now_ns = lambda: stamp_at(self.time)

    def now(self) -> float:
        """Return the time in s."""
        return self.time

    def go_to(self, count: int) -> None:
        """Go to a tick by its number."""
        self.count = count
        self.time = count / self.rate

    def stamp(self, count: int | None = None) -> int:
        """Return the stamp in ns of a tick; by default of the current one."""
        return stamp_at((self.count if count is None else count) / self.rate)

    def count_of(self, stamp: int) -> int:
        """Return the number of the tick with this stamp in ns."""
        return round((stamp - _FIRST_NS) * self.rate / 1e9)


def stamp_at(t: float) -> int:
    """Return the stamp in ns of time t in s."""
    return _FIRST_NS + round(t * 1e9)


class Follower(NamedTuple):
    """A process that follows simulated time: a controller of robots, or a recorder (no robots).

    Attributes:
        id: Number that no other follower has.
        process: Process ID, for messages.
        robots: Numbers of the robots that it controls.
    """

    id: int
    process: int
    robots: tuple[int, ...] = ()

    def __str__(self) -> str:
        kind = f'controller of {robots_in_words([*self.robots])}' if self.robots else 'recorder'
        return f'{kind} (process {self.process})'


class Answer(NamedTuple):
    """Progress of a follower.

    Attributes:
        follower: The follower.
        stamp: Stamp in ns of the newest states that it has finished with.
        commanded: Stamp in ns of the last commands that it sent; NO_STAMP if it sent none.
        leaves: Whether it stops following.
    """

    follower: Follower
    stamp: int
    commanded: int = NO_STAMP
    leaves: bool = False


def this_process(robots: tuple[int, ...] = ()) -> Follower:
    """Return this process as a follower."""
    return Follower(uuid.uuid4().int >> 65, os.getpid(), robots)


_VERSION = 1
_NB_FIELDS = 6  # before the robots


def encode(answer: Answer) -> array[int]:
    """Return an answer as the numbers of a message on /lockstep (docs/ros.md)."""
    id_number, process, robots = answer.follower
    fields = (_VERSION, id_number, process, answer.stamp, answer.commanded, answer.leaves)
    return array('q', (*fields, *robots))


def decode(numbers: Sequence[int]) -> Answer:
    """Return the answer in the numbers of a message; raise ValueError if it has none."""
    if len(numbers) < _NB_FIELDS or numbers[0] != _VERSION:
        raise ValueError(
            f'its numbers are {[*numbers[:_NB_FIELDS]]}; they must be {_VERSION} (version), id, '
            'process, stamp, commanded, leaves, robots'
        )
    _, id_number, process, stamp, commanded, leaves, *robots = numbers
    if not all(1 <= robot <= MAX_ROBOTS for robot in robots):
        raise ValueError(
            f'its robots are {reprlib.repr(robots)}; they must be from 1 to {MAX_ROBOTS}'
        )
    return Answer(Follower(id_number, process, tuple(robots)), stamp, commanded, bool(leaves))


class Roll:
    """Decides when simulated time may advance, and whom it waits for.

    At the start every robot needs a controller, and a recorder must be there if one is expected.
    Later time waits for the followers that are left; one controller is enough.
    """

    def __init__(self, robots: Sequence[int], recorded: bool, window_ns: int) -> None:
        """Start without followers.

        Args:
            robots: Numbers of the robots.
            recorded: Whether a recorder will follow.
            window_ns: How far a recorder may lag behind, in ns.
        """
        self._robots = set(robots)
        self._recorded = recorded
        self._window_ns = window_ns
        self._answers: dict[Follower, Answer] = {}
        self._left: list[Answer] = []
        self._begun = False

    def __len__(self) -> int:
        return len(self._answers)

    @property
    def controlled(self) -> set[int]:
        """The robots that have a controller."""
        return {robot for follower in self._answers for robot in follower.robots}

    def take(self, answer: Answer) -> None:
        """Store an answer."""
        if not answer.leaves:
            self._answers[answer.follower] = answer
        elif last := self._answers.pop(answer.follower, None):
            self._left.append(last)

    def left(self) -> list[Answer]:
        """Return the last answers of the controllers that have left since the last call."""
        left, self._left = self._left, []
        return [answer for answer in left if answer.follower.robots]

    def drop(self, late: Sequence[Answer]) -> None:
        """Remove followers that died without leaving."""
        for answer in late:
            self._answers.pop(answer.follower, None)

    def commanded(self) -> dict[int, int]:
        """Return the stamp in ns of the newest command sent to each robot."""
        return {
            robot: answer.commanded
            for answer in self._answers.values()
            if answer.commanded != NO_STAMP
            for robot in answer.follower.robots
        }

    def late(self, stamp: int, exactly: bool = False) -> list[Answer]:
        """Return the last answers of followers that have not finished with a time in ns.

        Args:
            stamp: The time of the newest states.
            exactly: Whether recorders, too, must have finished.
        """
        window = 0 if exactly else self._window_ns
        return [
            answer
            for answer in self._answers.values()
            # A stamp ahead of this time belongs to an earlier simulator.
            if not 0 <= stamp - answer.stamp <= (0 if answer.follower.robots else window)
        ]

    def missing(self, stamp: int) -> str:
        """Return the followers that are missing, as text; '' if time may advance."""
        without = sorted(self._robots - self.controlled)
        if not self._begun and without:
            return f'a controller of {robots_in_words(without)}'
        if without == sorted(self._robots):
            return 'a controller'
        if self._recorded and all(follower.robots for follower in self._answers):
            return 'the recorder'
        self._begun = self._begun or not self.late(stamp)
        return ''
