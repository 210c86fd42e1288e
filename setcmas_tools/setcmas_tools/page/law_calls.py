"""Calls of control laws on a page: wanted velocities, their outcomes, known poses."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.communication.links import Links
from setcmas_ctrl.communication.message_content import value_in_words
from setcmas_ctrl.filter.safety_filter import Verdict
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.reports.script_calls import Function, ScriptFailure
from setcmas_tools.measures.motion_metrics import SATURATION_TOLERANCE, largest_speed
from setcmas_tools.page.page_data import changes, packed
from setcmas_tools.page.run_history import RunHistory
from setcmas_tools.run.communication_record import CommunicationRecord, SentMessage
from setcmas_tools.run.fleet_motion import SAME_TIME_S
from setcmas_tools.run.law_output import MOVING
from setcmas_tools.run.run import Run, channel_of

_MOST_CALLS = 6_000
"""Of all robots; of longer runs the page has each second, fifth, ... call."""
_MOST_KNOWN = 300_000
"""Positions that robots knew of each other; with more, the page would be too large for a mail."""
_MOST_MESSAGES = 20_000
_TOO_MUCH = 'not on this page, because the run is too long'
_OVERRULED = {
    Verdict.CHANGED: 'The safety filter overruled it.',
    Verdict.NO_SOLUTION: 'The safety filter stopped it: no velocity was safe.',
}

Outcome = tuple[str, str]
"""Outcome of a wanted velocity: a kind, for its colour, and a sentence."""


def calls_entry(history: RunHistory) -> dict[int, dict[str, Any]]:
    """Return the calls of each robot's law, by its number."""
    run = history.run
    knowledge, fastest, sent = Knowledge(history), _fastest(run), _sent_values(run)
    each = 1 + len(run.commands.t) // _MOST_CALLS if run.commands else 1
    entries = {}
    for robot in history.robots:
        if run.commands:
            own = run.commands.of(robot)
            rows = np.flatnonzero(own.t >= history.t0 - SAME_TIME_S)[::each]
            t, wanted = own.t[rows], np.column_stack([own.vx, own.vy])[rows]
            filtered = own.allowed
        else:
            t = np.array([one.t for one in run.info.failures or [] if one.robot == robot])
            t = t[t >= history.t0 - SAME_TIME_S]
            rows, wanted, filtered = np.arange(len(t)), np.full((len(t), 2), np.nan), None
        if not len(t):
            continue
        verdicts = filtered.verdict[rows] if filtered else np.full(len(t), Verdict.KEPT)
        outcomes = _outcomes(history, robot, t, verdicts, np.hypot(*wanted.T) >= fastest)
        entry = {
            't': packed(t),
            'vx': packed(wanted[:, 0]),
            'vy': packed(wanted[:, 1]),
            'words': changes(outcomes),
        }
        if filtered:
            entry['allowedX'] = packed(filtered.vx[rows])
            entry['allowedY'] = packed(filtered.vy[rows])
        entry |= _known(history, knowledge, robot, t)
        entries[robot] = entry | sent.get(robot, {})
    return entries


def _sent_values(run: Run) -> dict[int, dict[str, Any]]:
    """Return the values that laws sent, as text, by the robots that sent any."""
    if len(run.messages) > _MOST_MESSAGES:
        return {}
    sent: dict[int, list[SentMessage]] = {}
    for message in run.messages:
        sent.setdefault(message.robot, []).append(message)
    return {robot: _texts(messages) for robot, messages in sent.items()}


def _texts(messages: Sequence[SentMessage]) -> dict[str, Any]:
    texts = changes([value_in_words(message.value) for message in messages])
    return {'messages': {'t': packed([message.t for message in messages]), 'texts': texts}}


def _fastest(run: Run) -> float:
    """Return the speed in m/s from which a law is saturated; inf if it is unknown."""
    try:
        return largest_speed(run) * (1 - SATURATION_TOLERANCE)
    except SetcmasError:
        return math.inf


def _outcomes(
    history: RunHistory, robot: int, t: Floats, verdicts: NDArray[Any], saturated: NDArray[Any]
) -> list[Outcome]:
    found = []
    for now, verdict, is_saturated in zip(t.tolist(), verdicts, saturated, strict=True):
        failure = failure_at(history.run, robot, now)
        state, held = history.safety(robot, now) or (MOVING, False)
        outcome = _outcome(failure, state, held, Verdict(int(verdict)))
        if not outcome[0] and is_saturated:
            outcome = 'saturated', 'The velocity is saturated at the speed limit.'
        found.append(outcome)
    return found


def _outcome(failure: ScriptFailure | None, state: str, held: bool, verdict: Verdict) -> Outcome:
    if failure:
        place = f' in line {failure.line} of {failure.script}' if failure.line else ''
        return 'failed', f'Its law failed{place}: {failure.first_line}'
    if state != MOVING:
        return 'stopped', f'The robot was {state} in the experiment.'
    if held or verdict is not Verdict.KEPT:
        return 'overruled', _OVERRULED.get(verdict, 'A safety function overruled it.')
    return '', ''


def failure_at(run: Run, robot: int, t: float) -> ScriptFailure | None:
    """Return the failure of a robot's law at a time in s; None if it worked."""
    for one in reversed(run.info.failures or []):
        until = math.inf if one.until is None else one.until
        own = one.robot == robot and one.function is Function.CONTROL
        if own and one.t - SAME_TIME_S <= t < until - SAME_TIME_S:
            return one
    return None


def _known(history: RunHistory, knowledge: Knowledge, robot: int, t: Floats) -> dict[str, Any]:
    """Return the poses of the others that a robot knew, unless it knew all."""
    if history.run.record is None:
        return {}
    calls = [knowledge.of(robot, now) for now in t.tolist()]
    sent = knowledge.sent(robot, t.tolist())
    if reason := next((unknown for poses, unknown in calls if poses is None), ''):
        return {'unknown': reason}
    known: Floats = np.array([poses for poses, _ in calls])
    if known.size * len(history.robots) > _MOST_KNOWN:
        return {'unknown': _TOO_MUCH}
    return {
        'known': [
            {
                'name': robot_name(sender + 1),
                'number': sender + 1,
                'x': packed(known[:, 0, sender]),
                'y': packed(known[:, 1, sender]),
            }
            | ({'sent': packed(sent[sender])} if sender in sent else {})
            for sender in range(known.shape[2])
            if sender + 1 != robot and np.isfinite(known[:, 0, sender]).any()
        ]
    }


_LOST = 'not known: the random losses or noise of a real-time run are not recorded'
_CHANNEL = 'not known: the delay, loss and noise of the links are not recorded'
_OTHERS = 'not known: the links do not reproduce the recorded messages'
_SENT, _CONNECTED, _CALLED, _ATTACHED = range(4)
_Event = tuple[float, int, Any]


class Knowledge:
    """Poses that robots knew when their laws were called.

    Without a record of communication each robot knows the newest poses of all. With one, the same
    links that the controllers use are played again: the record has the times at which states were
    sent, and their receivers; the random numbers follow from the seed.
    """

    def __init__(self, history: RunHistory) -> None:
        """Prepare; a robot's links are played at its first call of `of`."""
        self._history = history
        self._received: dict[int, tuple[Floats, Floats] | str] = {}
        self._contents: dict[int, list[dict[int, float]]] = {}

    def of(self, robot: int, t: float) -> tuple[Floats | None, str]:
        """Return the poses that a robot knew at a time in s, or why they are unknown.

        Returns:
            Rows x, y in m and theta in rad by robots' numbers from 1, shape (3, N), NaN for
            robots that it did not hear; and an empty text. Or None, and a reason.
        """
        record, newest = self._history.run.record, self._by_number(self._history.newest(t))
        if record is None:
            return newest, ''
        if robot not in self._received:
            self._received[robot] = self._played(robot, record)
        received = self._received[robot]
        if isinstance(received, str):
            return None, received
        times, poses = received
        call = int(np.searchsorted(times, t + SAME_TIME_S, side='right')) - 1
        known = poses[max(0, call)].copy()
        known[:, robot - 1] = newest[:, robot - 1]
        return known, ''

    def sent(self, robot: int, times: Sequence[float]) -> dict[int, list[float]]:
        """Return when the values that a robot had at some of its calls were sent.

        Args:
            robot: Its number.
            times: Times of the calls in s, shape (C,), for which `of` knows the poses.

        Returns:
            Times in s by sender, a column from 0, shape (C,); NaN where it had no value yet.
        """
        received = self._received.get(robot)
        if not isinstance(received, tuple):
            return {}
        places = np.searchsorted(received[0], np.array(times) + SAME_TIME_S, side='right') - 1
        held = [self._contents[robot][max(0, place)] for place in places.tolist()]
        senders = {sender for contents in held for sender in contents}
        return {sender: [one.get(sender, math.nan) for one in held] for sender in senders}

    def _played(self, robot: int, record: CommunicationRecord) -> tuple[Floats, Floats] | str:
        """Return the poses that a robot received, shape (C, 3, N), at the C calls of its law."""
        run, size = self._history.run, self._size
        channel = channel_of(run, size)
        if channel is None:
            return _CHANNEL
        if channel.is_random and run.info.started:
            return _LOST  # how many messages went before the first call is not recorded
        links = Links([robot], channel, run.info.seed)
        own = np.zeros((3, 1))
        times, poses, contents = [], [], []
        for t, kind, robots in self._events(robot, record):
            if kind == _SENT:
                links.send(robots, self._by_number(self._history.newest(t))[:, robots], t)
            elif kind == _CALLED:
                times.append(t)
                poses.append(links.known_poses(own, t)[0].copy())
                contents.append(links.contents(0))
            elif kind == _ATTACHED:
                links.attach(robots - 1, t)
            elif times:
                links.connect(robots, t)
            else:
                links.begin(robots)
        if channel.is_random and not _agrees(links, robot, record):
            return _OTHERS
        self._contents[robot] = contents
        return np.array(times), np.array(poses)

    def _events(self, robot: int, record: CommunicationRecord) -> Iterator[_Event]:
        """Yield the events, sorted by time; at one time states are sent first, and values last."""
        run, size = self._history.run, self._size
        changes = np.unique(record.changes[:, 0]).tolist()
        commands = run.commands
        calls = commands.t[commands.robot == robot] if commands else run.table.of(robot).t
        connected = ((t, _CONNECTED, record.adjacency(t, size)) for t in changes)
        called = ((t, _CALLED, None) for t in calls[calls >= 0.0].tolist())
        attached = ((one.t, _ATTACHED, one.robot) for one in run.messages)
        events = _sent(run, record), connected, called, attached
        yield from heapq.merge(*events, key=lambda one: one[:2])

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


def _agrees(links: Links, robot: int, record: CommunicationRecord) -> bool:
    """Return whether as many messages of each sender arrived as recorded."""
    counts = links.counts
    return all(
        (count.received, count.lost)
        == (counts.received[0, sender - 1], counts.lost[0, sender - 1])
        for (receiver, sender), count in record.links.items()
        if receiver == robot
    )
