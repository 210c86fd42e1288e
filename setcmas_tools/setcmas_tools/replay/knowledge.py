"""What a robot knew of the others: the links of a run played again from its record."""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from typing import Any

import numpy as np

from setcmas_ctrl.communication.channel import Channel
from setcmas_ctrl.communication.communication_options import CommunicationOptions
from setcmas_ctrl.communication.communication_settings import chosen_communication
from setcmas_ctrl.communication.links import Links
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.run.communication_record import CommunicationRecord
from setcmas_tools.run.fleet_motion import SAME_TIME_S
from setcmas_tools.run.run import Run

_LOST = 'not recorded: messages were lost or changed at random while the run went in real time'
_CHANNEL = 'not recorded: what delayed, lost or changed messages is not known'
_OTHERS = 'not recorded: messages went in another way than the record tells'
_SENT, _CONNECTED, _ASKED = range(3)
_Event = tuple[float, int, Any]


class Knowledge:
    """What robots knew at the calls of their laws.

    Without a record of communication each robot knows the newest poses of all. With one, the same
    links that the controllers use are played again: what was sent when, and who heard whom, is in
    the record, and the random numbers follow from the seed.
    """

    def __init__(self, history: RunHistory) -> None:
        """Prepare; a robot's links are played when it is asked for."""
        self._history = history
        self._heard: dict[int, tuple[Floats, Floats] | str] = {}

    def of(self, robot: int, t: float) -> tuple[Floats | None, str]:
        """Return what a robot knew at a time in s, or why that cannot be told.

        Returns:
            Rows x, y in m and theta in rad by robots' numbers from 1, shape (3, N), NaN for
            robots that it did not hear; and an empty text. Or None, and a reason.
        """
        record, newest = self._history.run.record, self._by_number(self._history.newest(t))
        if record is None:
            return newest, ''
        if robot not in self._heard:
            self._heard[robot] = self._played(robot, record)
        heard = self._heard[robot]
        if isinstance(heard, str):
            return None, heard
        times, poses = heard
        call = int(np.searchsorted(times, t + SAME_TIME_S, side='right')) - 1
        known = poses[max(0, call)].copy()
        known[:, robot - 1] = newest[:, robot - 1]
        return known, ''

    def _played(self, robot: int, record: CommunicationRecord) -> tuple[Floats, Floats] | str:
        """Return what a robot heard, shape (C, 3, N), at the C calls of its law."""
        run, size = self._history.run, self._size
        channel = _channel(run, size)
        if channel is None:
            return _CHANNEL
        if channel.is_random and run.info.started:
            return _LOST  # how many messages went before the first call is not recorded
        links = Links([robot], channel, run.info.seed)
        own = np.zeros((3, 1))
        times, poses = [], []
        for t, kind, told in self._events(robot, record):
            if kind == _SENT:
                links.send(told, self._by_number(self._history.newest(t))[:, told], t)
            elif kind == _ASKED:
                times.append(t)
                poses.append(links.heard(own, t)[0].copy())
            elif times:
                links.connect(told, t)
            else:
                links.begin(told)
        if channel.is_random and not _agrees(links, robot, record):
            return _OTHERS
        return np.array(times), np.array(poses)

    def _events(self, robot: int, record: CommunicationRecord) -> Iterator[_Event]:
        """Yield what happened, sorted by time; at one time states are sent first."""
        run, size = self._history.run, self._size
        changes = np.unique(record.changes[:, 0]).tolist()
        commands = run.commands
        calls = commands.t[commands.robot == robot] if commands else run.table.of(robot).t
        connected = ((t, _CONNECTED, record.adjacency(t, size)) for t in changes)
        asked = ((t, _ASKED, None) for t in calls[calls >= 0.0].tolist())
        yield from heapq.merge(_sent(run, record), connected, asked, key=lambda one: one[:2])

    @property
    def _size(self) -> int:
        adjacency = self._history.adjacency(0.0)
        assert adjacency is not None
        return len(adjacency)

    def _by_number(self, poses: Floats) -> Floats:
        """Return poses of the run's robots by the numbers of robots."""
        robots = self._history.robots
        size = robots[-1] if self._history.run.record is None else self._size
        result = np.full((3, size), np.nan)
        result[:, np.array(robots) - 1] = poses
        return result


def _sent(run: Run, record: CommunicationRecord) -> Iterator[_Event]:
    """Yield when states were sent, with the columns of the robots that sent them."""
    t, robots = run.table.t, run.table.robot
    if record.is_event_triggered:
        t, robots, sent = record.triggers.T
        t, robots = t[sent == 1], robots[sent == 1].astype(int)
    starts = np.flatnonzero(np.diff(t, prepend=-np.inf) > 0)
    for first, last in zip(starts, [*starts[1:], len(t)], strict=True):
        yield float(t[first]), _SENT, np.unique(robots[first:last]) - 1


def _channel(run: Run, size: int) -> Channel | None:
    """Return what happens to messages on their way; None if the run does not tell."""
    names = ('graph', 'delay', 'loss', 'noise')
    told = {name: run.parameters[name] for name in names if name in run.parameters}
    files = [given.path for given in run.inputs if given.option == 'graph']
    if files:
        told['graph'] = files[0]
    if not told:
        return None
    try:
        return chosen_communication(size, CommunicationOptions(**told), run.info.seed).channel
    except (SetcmasError, TypeError):
        return None


def _agrees(links: Links, robot: int, record: CommunicationRecord) -> bool:
    """Return whether as many messages of each sender arrived as the record tells."""
    counts = links.counts
    return all(
        (told.received, told.lost) == (counts.received[0, sender - 1], counts.lost[0, sender - 1])
        for (receiver, sender), told in record.links.items()
        if receiver == robot
    )
