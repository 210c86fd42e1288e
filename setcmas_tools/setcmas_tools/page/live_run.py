"""Live run: the state of running robots, and the messages that bring a page up to date."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.robots.models_by_name import UNICYCLE
from setcmas_tools.measures.agreement import CONSENSUS, disagreement
from setcmas_tools.page.document import look_entry
from setcmas_tools.run.fleet_motion import farthest_drive

LOST_S = 1.5
"""Silence in s from which a robot counts as lost."""
FORGOTTEN_S = 30.0
"""Silence in s from which a robot is not shown any more."""
MOST_FRAMES = 1200
"""Poses of two minutes, for pages that are opened later."""
CHARTS = (('Disagreement', 'm'), ('Least separation', 'm'), ('Mean speed', 'm/s'))
"""Names and units of the numbers that each frame has."""

Message = dict[str, Any]
Shape = dict[str, Any]
"""A shape as `plane.js` draws it: kind, places and size in m, colour and alpha."""

_MOVING_M_S = 0.005
_SILENCE_S = 2.0
_PAUSED_TIMEOUT_S = 0.5
_DIAGNOSIS_TIMEOUT_S = 2.0
_FARTHEST_M = 1e6


@dataclass(frozen=True)
class _Seen:
    """Pose (m, rad), speed (m/s) and time (s) of the newest odometry of a robot."""

    pose: tuple[float, float, float]
    speed: float
    time: float


@dataclass(frozen=True)
class RobotDiagnosis:
    """Kind, state and reason that an experiment reports of a robot, at a time in s."""

    kind: str
    state: str
    reason: str
    time: float


class _Items:
    """Values by key, and their changes that pages have not been sent; None is no value."""

    def __init__(self, values: Mapping[Any, Any] | None = None) -> None:
        known = {key: value for key, value in (values or {}).items() if value is not None}
        self.values, self.changes = known, dict(known)

    def put(self, key: Any, value: Any) -> None:
        """Note a value."""
        if self.values.get(key) != value:
            self.values[key] = self.changes[key] = value


class PauseStates:
    """Pauses and stops, as they were requested and as an experiment reports them.

    Attributes:
        requested: Whether a pause was the last request; in a simulation it is what happens.
        stopped: Whether the pause node of an experiment holds a stop.
    """

    def __init__(self) -> None:
        self.requested = self.stopped = False
        self._paused = False
        self._paused_time: float | None = None
        self.diagnoses: dict[int, RobotDiagnosis] = {}

    def announce(self, paused: bool, now: float) -> None:
        """Note the state that the pause node of an experiment reports."""
        self._paused, self._paused_time = paused, now

    def paused(self, now: float) -> bool:
        """Return whether the fleet is paused; so it is when the pause node is silent."""
        if self._paused_time is None:
            return self.requested
        return self._paused or now - self._paused_time > _PAUSED_TIMEOUT_S

    def describe(self, robot: int, speed: float, now: float) -> tuple[str, str]:
        """Return the state of a robot, at a speed in m/s and a time in s: its kind, and words."""
        found = self.diagnoses.get(robot)
        if found and now - found.time <= _DIAGNOSIS_TIMEOUT_S:
            parts = dict.fromkeys(filter(None, (found.state, found.reason)))  # each once
            return found.kind, ': '.join(parts)
        if self.paused(now):
            return 'stopped', 'paused'
        return '', 'moving' if abs(speed) >= _MOVING_M_S else 'standing'


class RunClock:
    """Time from the first command; it stops when commands end or are paused.

    Times are those of the simulation, if it has a time of its own.
    """

    def __init__(self) -> None:
        self._counted: float | None = None
        self._last = 0.0
        self._paused = False

    def command(self, now: float, paused: bool = False) -> None:
        """Note that a command came at a time in s, and whether the laws' own time is stopped."""
        if self._counted is None or not 0.0 <= now - self._last <= _SILENCE_S:
            self._counted = 0.0
        elif not self._paused:
            self._counted += now - self._last
        self._last, self._paused = now, paused

    def describe(self, now: float) -> str:
        """Return in words whether controllers command the robots."""
        if self._counted is None:
            return 'not controlled yet'
        return 'control has ended' if now - self._last > _SILENCE_S else 'running'

    def seconds(self, now: float) -> float | None:
        """Return the time of the run in s; None before the first command."""
        if self._counted is None:
            return None
        since = now - self._last
        return self._counted + (0.0 if self._paused or since > _SILENCE_S else since)


class LiveRun:
    """The state of running robots.

    Attributes:
        announced: Numbers of the robots that simulators and labs announce.
        models: Names of the models of robots whose model is announced.
        real: Whether this is an experiment, so that robots cannot be reset or started.
        ended: Whether all robots are gone; the last state stays.
        simulated: Time in s of a simulation that has its own.
        task: The task of the control law, if it is known.
    """

    def __init__(self, now: float) -> None:
        """Start without robots at a time in s."""
        self._t0 = now
        self.announced: list[int] = []
        self.models: dict[int, str] = {}
        self.real = self.ended = False
        self._items = {'shapes': _Items()}
        self.begin()

    def begin(self) -> None:
        """Forget the run that has ended: another one begins."""
        self.states, self.clock = PauseStates(), RunClock()
        self.simulated: float | None = None
        self.ended, self.task = False, ''
        self._seen: dict[int, _Seen] = {}
        self._put: set[int] = set()
        self._fresh = False
        self._sent: set[int] = set()
        self._items = {
            'looks': _Items(),
            'states': _Items(),
            'links': _Items(),
            'shapes': _Items(self._items['shapes'].values),
        }
        self._frames: deque[Message] = deque(maxlen=MOST_FRAMES)
        self._begins = True
        self._status: Message = {}

    @property
    def robots(self) -> list[int]:
        """Numbers of the robots that have been seen, sorted."""
        return sorted(self._seen)

    def command(self, now: float) -> None:
        """Note a command; the time of the control laws stops while they are paused."""
        self.clock.command(self._run_time(now), self.states.paused(now))

    def _run_time(self, now: float) -> float:
        return now if self.simulated is None else self.simulated

    def see(self, robot: int, pose: tuple[float, float, float], speed: float, now: float) -> None:
        """Note where a robot is.

        Args:
            robot: Its number.
            pose: x, y in m and theta in rad; ignored unless finite.
            speed: Along its heading in m/s.
            now: Time in s.
        """
        if not all(map(math.isfinite, (*pose, speed))):
            return
        last = self._seen.get(robot)
        if last is None or now - last.time > LOST_S:
            self._put.add(robot)
        else:
            step = max(now - last.time, 1e-3)
            distance = math.hypot(pose[0] - last.pose[0], pose[1] - last.pose[1])
            if distance > farthest_drive(max(abs(speed), abs(last.speed)), step):
                self._put.add(robot)
        self._seen[robot] = _Seen(pose, speed, now)
        self._fresh = True

    def trigger(self, robot: int) -> None:
        """Note that a robot has sent its state."""
        self._sent.add(robot)

    def connect(self, weights: Floats) -> None:
        """Note the links: row i hears column j, by robots' numbers from 1, shape (N, N).

        A row of NaN is not known: another controller process has it.
        """
        unknown = np.flatnonzero(np.isnan(weights).all(axis=1)) + 1
        known = np.nan_to_num(weights) * (1 - np.eye(len(weights)))
        pairs = np.argwhere(known > 0).tolist()
        links = {f'{i + 1} {j + 1}': round(float(known[i, j]), 4) for i, j in pairs}
        for pair in [*links.keys(), *(self._items['links'].values.keys() - links.keys())]:
            receiver, sender = map(int, pair.split())
            if receiver not in unknown or sender > len(weights):
                self._items['links'].put(pair, links.get(pair))

    def draw(self, topic: str, key: str, shape: Shape) -> None:
        """Note a shape, in place of that with the same topic and key."""
        self._items['shapes'].put(f'{topic}\0{key}', shape)

    def erase(self, topic: str) -> None:
        """Forget the shapes of a topic."""
        shapes = self._items['shapes']
        for name in [name for name in shapes.values if name.startswith(f'{topic}\0')]:
            shapes.put(name, None)

    def changes(self, now: float) -> list[Message]:
        """Return the messages that bring pages up to date since the last call, at a time in s."""
        if not self.ended:
            seen = self._seen.items()
            self._seen = {r: one for r, one in seen if now - one.time <= FORGOTTEN_S}
        t = self._t(now)
        self._describe_robots(now)
        found: list[Message] = [{'kind': 'begin'}] if self._begins else []
        for kind, items in self._items.items():
            if items.changes:
                found.append({'kind': kind, 't': t, 'items': [*items.changes.items()]})
                items.changes = {}
        if self._fresh:
            self._frames.append(self._frame(now))
            found.append(self._frames[-1])
        if self._sent:
            found.append({'kind': 'sent', 't': t, 'numbers': sorted(self._sent)})
        status = self._described(now)
        if status != self._status:
            found.append(status)
        self._begins, self._fresh, self._sent, self._status = False, False, set(), status
        return [*found, {'kind': 'now', 't': t}]

    def whole(self, now: float) -> list[Message]:
        """Return the messages that show a new page the run, at a time in s."""
        t = self._frames[0]['t'] if self._frames else self._t(now)
        items = [
            {'kind': kind, 't': t, 'items': [pair for pair in own.values.items() if pair[1]]}
            for kind, own in self._items.items()
        ]
        begin, end = {'kind': 'begin'}, {'kind': 'now', 't': self._t(now)}
        return [self._described(now), begin, *items, *self._frames, end]

    def _t(self, now: float) -> float:
        return round(now - self._t0, 3)

    def _lost(self, now: float) -> set[int]:
        seen = () if self.ended else self._seen.items()
        return {robot for robot, one in seen if now - one.time > LOST_S}

    def _frame(self, now: float) -> Message:
        robots, lost = self.robots, self._lost(now)
        put, self._put = sorted(self._put), set()
        seen = [self._seen[robot] for robot in robots]
        rows: Floats = np.array([(*one.pose, one.speed) for one in seen])
        poses = np.round(np.clip(rows, -_FARTHEST_M, _FARTHEST_M), 4)
        clock = self.clock.seconds(self._run_time(now))
        return {
            'kind': 'frame',
            't': self._t(now),
            'numbers': robots,
            'poses': poses.ravel().tolist(),
            'put': put,
            'clock': None if clock is None else round(clock, 3),
            'curves': [None] * len(CHARTS)
            if clock is None  # nothing has commanded these robots yet
            else _curves(rows[[robot not in lost for robot in robots]], self.task),
        }

    def _describe_robots(self, now: float) -> None:
        robots, lost = self.robots, self._lost(now)
        for robot in robots:
            kind, text = self.states.describe(robot, self._seen[robot].speed, now)
            if self.ended:
                kind, text = '', 'at the end'
            elif robot in lost:
                kind, text = 'failed', 'lost'
            self._items['states'].put(robot, (kind, text.partition(':')[0], text))
            look = look_entry(robot, self.models.get(robot, UNICYCLE), len(robots))
            self._items['looks'].put(robot, look)

    def _described(self, now: float) -> Message:
        robots, paused = self.robots, self.states.paused(now)
        lost = len(self._lost(now))
        unseen = sorted(set(self.announced) - set(robots))
        count = f'{len(robots)} robot{"" if len(robots) == 1 else "s"}'
        state = 'paused' if paused else self.clock.describe(self._run_time(now))
        if not robots:
            state = 'waiting for robots'
        if self.ended:
            state = 'run ended'
        elif self.states.stopped:
            state = 'STOP HELD'
        remarks = [f'{lost} lost'] if lost else []
        if unseen and not self.ended:
            remarks.append(f'{robots_in_words(unseen, "are")} announced, but not seen')
        return {
            'kind': 'status',
            'title': count,
            'detail': '; '.join(remarks),
            'state': state,
            'paused': paused,
            'stopped': self.states.stopped,
            'real': self.real,
            'ended': self.ended,
        }


def live_content(has_buttons: bool) -> Mapping[str, Any]:
    """Return the content of a live page that other pages lack."""
    charts = [{'name': name, 'unit': unit, 'values': {}} for name, unit in CHARTS]
    return {'charts': charts, 'live': {'commands': has_buttons}}


def _curves(rows: Floats, task: str) -> list[float | None]:
    """Return the numbers of `CHARTS` for robots, rows x, y, theta, v, shape (N, 4).

    Robots with another task than consensus need not agree, so they have no disagreement.
    """
    if not len(rows):
        return [None, None, None]
    x, y, speed = rows[:, 0], rows[:, 1], float(np.abs(rows[:, 3]).mean())
    if len(rows) < 2:
        return [None, None, round(speed, 4)]
    apart = np.hypot(x[:, None] - x, y[:, None] - y)
    np.fill_diagonal(apart, np.inf)
    meets = task in ('', CONSENSUS)
    spread = round(float(disagreement(x[:, None], y[:, None])[0]), 4) if meets else None
    return [spread, round(float(apart.min()), 4), round(speed, 4)]
