"""Latency of an experiment: the ages of its commands, part by part from camera to motion."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.compare.identification import Identified, identify
from setcmas_tools.measures.consensus_metrics import CONSENSUS
from setcmas_tools.measures.metric import Measured
from setcmas_tools.run.run import Run

PARTS = ('camera to bridge', 'bridge to law', 'law', 'law to base', 'base to motion')
CAMERA, BRIDGE, LAW, WAY, MOTION = PARTS
MOST_DOUBT_S = 0.01
"""Largest uncertainty of a known part, in s."""

_WINDOW_S = 10.0  # in which clocks do not drift apart
_LONGEST_S = 0.5
_SAME = 1e-6
_SLOW_M_S = 0.02  # near the dead band
_NEAR_LIMIT = 0.95  # of the largest speed: such commands may be saturated
_FITS = 0.1  # largest part of the commands that a gain leaves unexplained


@dataclass(frozen=True)
class Part:
    """Ages in s: their median, and the worst."""

    median_s: float
    worst_s: float


class Offset(NamedTuple):
    """By how much another clock is ahead of this one, and the uncertainty, in s."""

    seconds: float
    doubt: float


HERE = Offset(0.0, 0.0)


@dataclass
class RobotTimes:
    """Recorded times of one robot in s since 1970, on the clocks of their senders.

    Attributes:
        cameras: Rows of arrival, median and worst age of samples in the bridge.
        laws: Rows of the time of a call of the law, and the stamp of the pose.
        wanted: Rows of stamp, V, omega of the law's commands.
        guarded: Rows of arrival here, stamp of the guard, V, omega of commands to the base.
        ways: Rows of arrival here of a guard's report, and its shortest time from a stamp here to
            arrival there.
        clocks: Whose clocks those of camera and robot are: bridge, robot, or empty if unknown.
    """

    cameras: list[tuple[float, ...]] = field(default_factory=list)
    laws: list[tuple[float, ...]] = field(default_factory=list)
    wanted: list[tuple[float, ...]] = field(default_factory=list)
    guarded: list[tuple[float, ...]] = field(default_factory=list)
    ways: list[tuple[float, ...]] = field(default_factory=list)
    clocks: dict[str, str] = field(default_factory=dict)


def clock_offsets(times: RobotTimes) -> Callable[[float], Offset | None]:
    """Return a function of time here (s) for the offset of a robot's clock; None if unknown.

    A command arrives after it was stamped here, and its answer arrives here after it was stamped
    there: these bound the offset from both sides (Cristian, Probabilistic clock synchronization,
    Distributed Computing 3, 1989), with the promptest messages of a window best.
    """
    if times.clocks.get('robot') == 'bridge':
        return lambda _: HERE
    upper: dict[int, float] = defaultdict(lambda: math.inf)
    lower: dict[int, float] = defaultdict(lambda: -math.inf)
    for at, way in times.ways:
        upper[int(at / _WINDOW_S)] = min(upper[int(at / _WINDOW_S)], way)
    for at, stamp, *_ in times.guarded:
        lower[int(at / _WINDOW_S)] = max(lower[int(at / _WINDOW_S)], stamp - at)
    found = {
        window: Offset((upper[window] + least) / 2, (upper[window] - least) / 2)
        for window, least in lower.items()
        if stamp_is_set(least) and 0.0 <= upper[window] - least <= 2 * MOST_DOUBT_S
    }
    return lambda at: found.get(int(at / _WINDOW_S))


def stamp_is_set(difference: float) -> bool:
    """Return whether a difference in s to now is that of a stamp, which is 0 if not set."""
    return abs(difference) < 1e9


def parts_of(times: RobotTimes) -> dict[str, Part | None]:
    """Return the parts up to the base by name; None where unknown."""
    offset = clock_offsets(times)
    return {
        CAMERA: _camera(times, offset),
        BRIDGE: _part([called - pose for called, pose in times.laws if pose]),
        LAW: _part(_law_ages(times)),
        WAY: _part(_way_ages(times, offset)),
    }


def _part(ages: list[float], worst: list[float] | None = None) -> Part | None:
    # Events do not precede their causes: clocks that nothing aligns made these ages.
    if not ages or min(ages) < -MOST_DOUBT_S:
        return None
    return Part(max(0.0, float(np.median(ages))), max(0.0, *ages, *(worst or [])))


def _camera(times: RobotTimes, offset: Callable[[float], Offset | None]) -> Part | None:
    clock = times.clocks.get('camera')
    medians, worst = [], []
    for at, median, largest in times.cameras:
        ahead = {'bridge': HERE, 'robot': offset(at)}.get(clock or '')
        if ahead:
            medians.append(median + ahead.seconds)
            worst.append(largest + ahead.seconds)
    return _part(medians, worst)


def _law_ages(times: RobotTimes) -> list[float]:
    sent = np.array(sorted(stamp for stamp, *_ in times.wanted))
    calls = np.array([called for called, _ in times.laws])
    after = np.searchsorted(sent, calls)
    known = after < len(sent)
    ages = sent[after[known]] - calls[known]
    found: list[float] = ages[ages < _LONGEST_S].tolist()
    return found


def _way_ages(times: RobotTimes, offset: Callable[[float], Offset | None]) -> list[float]:
    """Return the ages of new commands when the guard passes them on to the base."""
    if not times.guarded:
        return []
    at, stamps, *velocities = np.array(times.guarded).T
    ages = []
    last: tuple[float, ...] = (0.0, 0.0)
    for sent, *command in times.wanted:
        is_new, last = tuple(command) != last and any(command), tuple(command)
        first, end = np.searchsorted(at, (sent, sent + _LONGEST_S))
        wrong = np.abs(np.array(velocities)[:, first:end] - np.array(command)[:, None])
        same = np.flatnonzero(wrong.max(axis=0, initial=0.0) < _SAME)
        ahead = offset(sent)
        if is_new and len(same) and ahead:
            ages.append(float(stamps[first + same[0]]) - ahead.seconds - sent)
    return ages


def motion_part(one: Identified, camera: Part | None) -> Part | None:
    """Return the time from a command at the base to motion: identified lag and delay.

    Without odometry of its wheels, the age of poses is part of the delay, and taken off.
    """
    known = []
    for channel in one.channels.values():
        fit, errors = channel.fit, channel.fit.errors
        of_poses = channel.measured_with != 'wheels'
        is_known = fit.times_known and errors.lag + errors.delay <= 2 * MOST_DOUBT_S
        if is_known and (camera or not of_poses):
            age = camera.median_s if camera and of_poses else 0.0
            known.append(max(0.0, fit.response.lag + fit.response.delay - age))
    return Part(float(np.median(known)), max(known)) if known else None


class _Recorded:
    """Collects the times of all robots from a bag; times of arrival are in ns since 1970."""

    def __init__(self, start_ns: int) -> None:
        self._start_ns = start_ns
        self.robots: dict[int, RobotTimes] = defaultdict(RobotTimes)

    def takers(self, name: str) -> list[Callable[[int, Any], None]]:
        """Return the functions that take the messages of a topic."""
        if name == topics.DIAGNOSTICS:
            return [self._take_statuses]
        robot = topics.robot_of(name)
        if not robot:
            return []
        times = self.robots[robot]
        kind = name.removeprefix(topics.robot_topic(robot, ''))
        taker = {
            topics.LAW_TIME: lambda _, one: times.laws.append(
                (_s(one.header.stamp), _s(one.time_ref))
            ),
            topics.CMD_VEL_WANTED: lambda _, one: times.wanted.append(_command(one)),
            topics.CMD_VEL_GUARDED: lambda at, one: times.guarded.append(
                (at / 1e9, *_command(one))
            ),
            topics.GUARD_STATE: lambda at, one: self._take_report(times, at, one),
        }.get(kind)
        return [taker] if taker else []

    def _take_statuses(self, at_ns: int, message: Any) -> None:
        for status in message.status:
            robot = topics.robot_of(f'/{status.name}/')
            values = {pair.key: pair.value for pair in status.values}
            if not robot or 'camera_clock' not in values:
                continue
            times = self.robots[robot]
            times.clocks = {
                'camera': values['camera_clock'],
                'robot': values.get('robot_clock', ''),
            }
            ages = [values.get(key, '') for key in ('camera_age', 'camera_age_worst')]
            if at_ns >= self._start_ns and all(ages):
                times.cameras.append((at_ns / 1e9, *map(float, ages)))

    def _take_report(self, times: RobotTimes, at_ns: int, message: Any) -> None:
        values = {pair.key: pair.value for pair in message.values}
        if way := values.get('command_way'):
            times.ways.append((at_ns / 1e9, float(way)))


def _s(stamp: Any) -> float:
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def _command(message: Any) -> tuple[float, float, float]:
    twist = getattr(message, 'twist', message)
    stamp = _s(message.header.stamp) if twist is not message else 0.0
    return stamp, twist.linear.x, twist.angular.z


def recorded_times(bag_path: Path) -> dict[int, RobotTimes]:
    """Return the times of the robots in the bag of an experiment.

    Raises:
        SetcmasError: The bag cannot be read.
    """
    from setcmas_tools.bags.bag import open_bag  # CSV files are read without rosbags

    with open_bag(bag_path) as bag:
        recorded = _Recorded(bag.first_command({}))
        bag.deliver({topic: recorded.takers(topic.name) for topic in bag.topics}, 0)
    return {robot: times for robot, times in sorted(recorded.robots.items()) if times.laws}


@dataclass(frozen=True)
class Latency(Measured):
    """Ages of commands in an experiment.

    Attributes:
        parts: By robot and name of the part; None where unknown.
        clocks: Offset and uncertainty in s of the robots' clocks that are not this machine's.
        bearable_s: The delay that the law can bear; None if unknown.
    """

    parts: Mapping[int, Mapping[str, Part | None]]
    clocks: Mapping[int, Offset]
    bearable_s: float | None = None

    def lines(self) -> list[str]:
        """Return a line for each robot, and what the law can bear."""
        lines = ['latency in ms, median (worst):']
        for robot, parts in self.parts.items():
            shown = [f'{name} {_ms(parts.get(name))}' for name in PARTS]
            lines.append(f'  {robot_name(robot)}: {", ".join(shown)}')
        for robot, (ahead, doubt) in self.clocks.items():
            way = 'ahead' if ahead > 0.0 else 'behind'
            lines.append(
                f'  the clock of {robot_name(robot)} is {abs(ahead):.4f} s {way}, '
                f'± {1000 * doubt:.1f} ms'
            )
        if self.bearable_s is not None:
            lines.append(
                f'  delay margin of the law: {1000 * self.bearable_s:.0f} ms (single integrators '
                'on a complete graph: pi / (2 K))'
            )
        return lines

    def as_dict(self) -> dict[str, Any]:
        """Return the parts by robot, in s."""
        return {
            'parts_s': {
                robot: {
                    name.replace(' ', '_'): [part.median_s, part.worst_s] if part else None
                    for name, part in parts.items()
                }
                for robot, parts in self.parts.items()
            },
            'clock_offset_s': {robot: list(one) for robot, one in self.clocks.items()},
            'bearable_s': self.bearable_s,
        }


def _ms(part: Part | None) -> str:
    return f'{1000 * part.median_s:.0f} ({1000 * part.worst_s:.0f})' if part else 'unknown'


def fleet_latency(run: Run) -> Latency | None:
    """Return the latency of an experiment; None for other runs, or without its bag."""
    if run.tables.safety is None or run.bag is None:
        return None
    recorded = recorded_times(run.bag)
    if not recorded:
        return None
    found = _identified(run.bag)
    parts, clocks = {}, {}
    for robot, times in recorded.items():
        own = parts_of(times)
        own[MOTION] = motion_part(found[robot], own[CAMERA]) if robot in found else None
        parts[robot] = own
        offset = clock_offsets(times)
        known = [one for at, *_ in times.guarded if (one := offset(at))]
        if times.clocks.get('robot') != 'bridge' and known:
            clocks[robot] = known[-1]
    return Latency(parts, clocks, bearable_delay(run))


def _identified(bag: Path) -> Mapping[int, Identified]:
    try:
        return identify(bag, lambda _: None)
    except SetcmasError:  # no commands, or scipy is missing: unknown
        return {}


def bearable_delay(run: Run) -> float | None:
    """Return the delay in s up to which consensus converges; None for other tasks and graphs.

    It is pi / (2 lambda_n) of single integrators with equal delays (Olfati-Saber and Murray, IEEE
    Transactions on Automatic Control 49(9), 2004, theorem 10). On a complete graph lambda_n is the
    gain K of a law v_i = -K (p_i - centre).
    """
    if run.references is None or run.references.task != CONSENSUS or run.record is not None:
        return None
    gain = _gain(run)
    return math.pi / (2.0 * gain) if gain else None


def _gain(run: Run) -> float | None:
    """Return the K that the commands show; None unless they are those of such a law."""
    given = run.commands
    if given is None:
        return None
    wanted = np.stack([given.vx, given.vy])
    tracks = [run[robot] for robot in run.robots]
    places = np.array(  # shape (2, N, rows)
        [
            [np.interp(given.t, track.t, track.x) for track in tracks],
            [np.interp(given.t, track.t, track.y) for track in tracks],
        ]
    )
    own = places[:, np.searchsorted(run.robots, given.robot), np.arange(len(given.t))]
    offset = own - places.mean(axis=1)
    speed = np.hypot(*wanted)
    free = (speed > _SLOW_M_S) & (speed < _NEAR_LIMIT * speed.max(initial=0.0))
    wanted, offset = wanted[:, free], offset[:, free]
    square = np.sum(offset**2)
    if not square:
        return None
    gain = float(-np.sum(wanted * offset) / square)
    left = np.linalg.norm(wanted + gain * offset) / np.linalg.norm(wanted)
    return gain if gain > 0.0 and left < _FITS else None
