"""Lockstep: simulated time that advances when all followers have answered."""

from __future__ import annotations

import os
import reprlib
import uuid
from array import array
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.topics import MAX_ROBOTS
from setcmas_simu.ros import messages

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


class Commands(NamedTuple):
    """Commands of a follower's robots at one time.

    Attributes:
        stamp: The time in ns.
        rows: For each robot, speeds forward and left (m/s) and turn rate (rad/s), velocity of its
            law (m/s), velocity after the safety filter (m/s) and the filter's verdict; NaN for
            missing values.
    """

    stamp: int
    rows: tuple[tuple[float, ...], ...]


class Answer(NamedTuple):
    """Progress of a follower.

    Attributes:
        follower: The follower.
        stamp: Stamp in ns of the newest states that it has finished with.
        leaves: Whether it stops following.
        commands: Commands since its last answer, the oldest first.
    """

    follower: Follower
    stamp: int
    leaves: bool = False
    commands: tuple[Commands, ...] = ()


def this_process(robots: tuple[int, ...] = ()) -> Follower:
    """Return this process as a follower."""
    return Follower(uuid.uuid4().int >> _NO_ID_BITS, os.getpid(), robots)


_NO_ID_BITS = 128 - 53  # all whole numbers up to 2^53 are exact in a message
_VERSION = 2
_NB_FIELDS = 6  # before the robots
_NB_COMMANDED = 8  # numbers of a robot's command


def encode(answer: Answer) -> array[float]:
    """Return an answer as the numbers of a message on /lockstep (docs/ros.md)."""
    id_number, process, robots = answer.follower
    numbers = array('d', (_VERSION, id_number, process, answer.stamp, answer.leaves, len(robots)))
    numbers.extend(robots)
    for stamp, rows in answer.commands:
        numbers.append(stamp)
        for row in rows:
            numbers.extend(row)
    return numbers


def decode(numbers: Sequence[float]) -> Answer:
    """Return the answer in the numbers of a message; raise ValueError if it has none."""
    try:
        head = [*map(int, numbers[:_NB_FIELDS])]
    except (ValueError, OverflowError):  # NaN or infinite
        head = []
    if len(head) < _NB_FIELDS or head[0] != _VERSION:
        raise ValueError(
            f'its numbers are {[*numbers[:_NB_FIELDS]]}; they must be {_VERSION} (version), id, '
            'process, stamp, leaves, number of robots, robots, commands'
        )
    _, id_number, process, stamp, leaves, nb_robots = head
    robots, rest = numbers[_NB_FIELDS:][:nb_robots], numbers[_NB_FIELDS + nb_robots :]
    if not all(1 <= robot <= MAX_ROBOTS and robot % 1 == 0 for robot in robots):
        raise ValueError(
            f'its robots are {reprlib.repr([*robots])}; they must be from 1 to {MAX_ROBOTS}'
        )
    follower = Follower(id_number, process, tuple(map(int, robots)))
    if len(robots) != nb_robots or len(rest) % (size := 1 + _NB_COMMANDED * nb_robots):
        raise ValueError(
            f'it has {len(robots)} of {nb_robots} robots and {len(rest)} numbers of commands; '
            f'these must be a stamp and {_NB_COMMANDED} numbers for each robot, or several times'
        )
    blocks = [rest[i : i + size] for i in range(0, len(rest), size)]
    return Answer(follower, stamp, bool(leaves), tuple(map(_commands, blocks)))


def _commands(block: Sequence[float]) -> Commands:
    starts = range(1, len(block), _NB_COMMANDED)
    stamp = _stamp(block[0], 'a stamp of its commands')
    return Commands(stamp, tuple(tuple(block[i : i + _NB_COMMANDED]) for i in starts))


_LAST_STAMP = 2**53


def _stamp(number: float, name: str) -> int:
    if not 0 <= number < _LAST_STAMP:
        raise ValueError(f'{name} is {number:g}; it must be a time in ns')
    return int(number)


class States(NamedTuple):
    """States of all robots of a simulator at one time.

    Attributes:
        stamp: The time in ns.
        table: A row for each robot: number, x and y in m, z and w of its quaternion, speeds
            forward and left in m/s, turn rate in rad/s; shape (N, 8).
    """

    stamp: int
    table: Floats


_NB_STATES = 8


def encode_states(states: States) -> array[float]:
    """Return states as the numbers of a message on /lockstep_states (docs/ros.md)."""
    numbers = array('d', (_VERSION, states.stamp))
    numbers.frombytes(states.table.tobytes())
    return numbers


def decode_states(numbers: array[float]) -> States:
    """Return the states in the numbers of a message; raise ValueError if it has none."""
    if len(numbers) < 2 or numbers[0] != _VERSION or (len(numbers) - 2) % _NB_STATES:
        raise ValueError(
            f'its numbers are {reprlib.repr([*numbers])}; they must be {_VERSION} (version), '
            f'stamp, and {_NB_STATES} numbers for each robot'
        )
    table = np.array(numbers[2:]).reshape(-1, _NB_STATES)
    if len(invalid := table[~np.isfinite(table).all(axis=1)]):
        raise ValueError(f'a row of its states is {invalid[0].tolist()}; it must be finite')
    return States(_stamp(numbers[1], 'its stamp'), table)


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
