"""A run at an instant: poses, links, and what each robot knew."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from setcmas_ctrl.communication.channel import Channel
from setcmas_ctrl.communication.communication_settings import (
    CommunicationOptions,
    chosen_communication,
)
from setcmas_ctrl.communication.links import Links
from setcmas_ctrl.filter.safety_filter import Verdict
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.reports.script_calls import Function, ScriptFailure
from setcmas_tools.compare.run_distance import distances_between
from setcmas_tools.measures.consensus_metrics import disagreement, is_agreement
from setcmas_tools.measures.motion_metrics import SATURATION_TOLERANCE, largest_speed
from setcmas_tools.measures.safety_metrics import distances_of_pairs
from setcmas_tools.measures.task import task_of
from setcmas_tools.page.run_history import NewestRows, RunHistory
from setcmas_tools.plots.trajectories import ignore
from setcmas_tools.run.communication_record import CommunicationRecord
from setcmas_tools.run.fleet_motion import SAME_TIME_S, Track
from setcmas_tools.run.run import Run

FLEET = 0
"""The number under which a curve has the values of the whole fleet."""


@dataclass(frozen=True)
class Curve:
    """What is measured over time.

    Attributes:
        name: Such as 'Disagreement'.
        unit: Such as 'm'.
        t: K times in s.
        values: By robot, or one of the whole `FLEET`, shape (K,); NaN where nothing is known.
    """

    name: str
    unit: str
    t: Floats
    values: Mapping[int, Floats]


def curves(run: Run) -> list[Curve]:
    """Return what is measured of a run from its first command on, as plots and metrics do."""
    grid = run.counted_grid if len(run.counted.t) else run.grid()
    found = [
        Curve('Speed', 'm/s', grid.t, {robot: _speeds(run, robot, grid.t) for robot in run.robots})
    ]
    if len(grid.robots) > 1 and len(grid.t):
        least = distances_of_pairs(grid)[0]
        found.insert(0, Curve('Least separation', 'm', grid.t, {FLEET: least}))
        if is_agreement(run):
            values = disagreement(grid.x, grid.y)
            found.insert(0, Curve('Disagreement', 'm', grid.t, {FLEET: values}))
    known = task_of(run, ignore)
    errors = known[0].errors(run, known[1]) if known and len(run.counted.t) else None
    if errors:
        found.append(Curve(errors.title, 'm', grid.t, errors.values))
    return found


def difference(run: Run, other: Run) -> Curve | None:
    """Return how far each robot of a run is from itself in another one at the same time, in m.

    None if no robot is in both.
    """
    t, distances = distances_between(run, other)
    return Curve('Difference', 'm', t, distances) if len(t) and distances else None


def _speeds(run: Run, robot: int, t: Floats) -> Floats:
    """Return a robot's speed at times, each row for the time before it; NaN in gaps."""
    track = Track(run[robot])
    speeds = np.append(track.rows.v, np.nan)[np.searchsorted(track.rows.t, t - SAME_TIME_S)]
    return np.where(np.isnan(track.poses(t)[0]), np.nan, speeds)


Velocity = tuple[float, float]
_LOST = 'not recorded: messages were lost or changed at random while the run went in real time'
_CHANNEL = 'not recorded: what delayed, lost or changed messages is not known'
_OTHERS = 'not recorded: the links do not reproduce the recorded messages'
_SENT, _CONNECTED, _ASKED = range(3)
_Event = tuple[float, int, Any]


@dataclass(frozen=True)
class RobotInstant:
    """A robot at a time; None for what is not recorded.

    Attributes:
        robot: Its number.
        t: The time in s.
        called_at: When its law was called last, in s.
        wanted: What its law then wanted after saturation: vx, vy in m/s.
        saturated: Whether that was the largest speed that robots are asked for.
        allowed: What the safety filter let through: vx, vy in m/s; None without one.
        verdict: What the filter did.
        state: What an experiment let it do, such as 'moving' or 'paused'.
        overruled: Whether the filter or the experiment did not let it do what its law wanted.
        failure: The failure of its law, if it failed then.
        known: What it then knew of the fleet: rows x, y, theta by robots' numbers from 1, NaN for
            robots that it did not hear.
        unknown: Why `known` is None.
    """

    robot: int
    t: float
    called_at: float | None
    wanted: tuple[float, float] | None
    saturated: bool | None
    allowed: tuple[float, float] | None
    verdict: Verdict | None
    state: str | None
    overruled: bool | None
    failure: ScriptFailure | None
    known: Floats | None
    unknown: str


class Instants:
    """Robots at instants of a run."""

    def __init__(self, history: RunHistory) -> None:
        """Look up the run's commands."""
        self._history = history
        self._commands = history.run.commands
        commands = self._commands
        self._newest = NewestRows(commands.t, commands.robot) if commands else None
        self._knowledge = Knowledge(history)
        self._fastest = _fastest(history.run)

    def of(self, robot: int, t: float) -> RobotInstant:
        """Return a robot at a time in s."""
        history = self._history
        row = self._newest.row(robot, t) if self._newest else None
        called_at, wanted, allowed, verdict = self._command(row)
        state, held = history.safety(robot, t) or (None, None)
        changed = None if verdict is None else verdict is not Verdict.KEPT
        called = t if called_at is None else called_at
        known, unknown = self._knowledge.of(robot, called)
        return RobotInstant(
            robot=robot,
            t=t,
            called_at=called_at,
            wanted=wanted,
            saturated=self._is_saturated(wanted),
            allowed=allowed,
            verdict=verdict,
            state=state,
            overruled=None if held is None and changed is None else bool(held or changed),
            failure=failure_at(history.run, robot, called),
            known=known,
            unknown=unknown,
        )

    def _command(
        self, row: int | None
    ) -> tuple[float | None, Velocity | None, Velocity | None, Verdict | None]:
        """Return when a law was called, what it wanted, what was allowed, and the verdict."""
        commands = self._commands
        if commands is None or row is None:
            return None, None, None, None
        t, wanted = float(commands.t[row]), (float(commands.vx[row]), float(commands.vy[row]))
        filtered = commands.allowed
        if filtered is None:
            return t, wanted, None, None
        allowed = float(filtered.vx[row]), float(filtered.vy[row])
        return t, wanted, allowed, Verdict(int(filtered.verdict[row]))

    def _is_saturated(self, wanted: Velocity | None) -> bool | None:
        if wanted is None or self._fastest is None:
            return None
        return math.hypot(*wanted) >= self._fastest * (1 - SATURATION_TOLERANCE)


def _fastest(run: Run) -> float | None:
    try:
        return largest_speed(run)
    except SetcmasError:
        return None


def failure_at(run: Run, robot: int, t: float) -> ScriptFailure | None:
    """Return the failure of a robot's law that went on at a time in s; None if it worked."""
    end = run.info.reloads[0].t if run.info.reloads else math.inf  # another version follows
    for one in reversed(run.info.failures or []):
        until = end if one.until is None else one.until
        mine = one.robot == robot and one.function is Function.CONTROL
        if mine and one.t - SAME_TIME_S <= t < until - SAME_TIME_S:
            return one
    return None


class Knowledge:
    """What robots knew at the calls of their laws.

    Without a record of communication each robot knows the newest poses of all. With one, the same
    links that the controllers use are played again: what was sent when, and which robot received
    it, is in the record, and the random numbers follow from the seed.
    """

    def __init__(self, history: RunHistory) -> None:
        """Prepare; a robot's links are played when it is asked for."""
        self._history = history
        self._received: dict[int, tuple[Floats, Floats] | str] = {}

    def of(self, robot: int, t: float) -> tuple[Floats | None, str]:
        """Return what a robot knew at a time in s, or why that is unknown.

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

    def _played(self, robot: int, record: CommunicationRecord) -> tuple[Floats, Floats] | str:
        """Return the poses that a robot received, shape (C, 3, N), at the C calls of its law."""
        run, size = self._history.run, self._size
        channel = _channel(run, size)
        if channel is None:
            return _CHANNEL
        if channel.is_random and run.info.started:
            return _LOST  # how many messages went before the first call is not recorded
        links = Links([robot], channel, run.info.seed)
        own = np.zeros((3, 1))
        times, poses = [], []
        for t, kind, robots in self._events(robot, record):
            if kind == _SENT:
                links.send(robots, self._by_number(self._history.newest(t))[:, robots], t)
            elif kind == _ASKED:
                times.append(t)
                poses.append(links.known_poses(own, t)[0].copy())
            elif times:
                links.connect(robots, t)
            else:
                links.begin(robots)
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
    """Return what happens to messages on their way; None if the run does not record it."""
    names = ('graph', 'delay', 'loss', 'noise')
    values = {name: run.parameters[name] for name in names if name in run.parameters}
    files = [given.path for given in run.inputs if given.option == 'graph']
    if files:
        values['graph'] = files[0]
    if not values:
        return None
    try:
        return chosen_communication(size, CommunicationOptions(**values), run.info.seed).channel
    except (SetcmasError, TypeError):
        return None


def _agrees(links: Links, robot: int, record: CommunicationRecord) -> bool:
    """Return whether as many messages of each sender arrived as recorded."""
    counts = links.counts
    return all(
        (count.received, count.lost)
        == (counts.received[0, sender - 1], counts.lost[0, sender - 1])
        for (receiver, sender), count in record.links.items()
        if receiver == robot
    )
