"""Commands and motion of one robot, from the bag of a run."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_tools.run.fleet_motion import FleetTable, gaps
from setcmas_tools.run.run_folder import find_run
from setcmas_tools.run.run_samples import FleetSamples

if TYPE_CHECKING:
    from setcmas_tools.bags.bag_reader import BagTopic, Taker

WINDOW_S = 0.2
"""Time over which speeds are means: poses that are a little wrong make speeds very wrong."""


@dataclass(frozen=True)
class Steps:
    """Mean speeds over windows.

    Attributes:
        begin: Starts of the windows in s, shape (K,).
        end: Their ends in s, shape (K,).
        speeds: Rows of mean forward speeds (m/s) and turn rates (rad/s), shape (2, K).
        overlap: Number of windows that overlap.
    """

    begin: Floats
    end: Floats
    speeds: Floats
    overlap: float


def steps_of(track: FleetTable) -> Steps:
    """Return the mean speeds of a robot in windows of `WINDOW_S`, one from each pose on.

    The forward way is the arc whose chord joins two poses, with the heading of its middle:
    s = (dx cos m + dy sin m) (a / sin a), m the mean of the headings, a half of their difference.
    """
    track = track.rows(np.isfinite(track.x + track.y + track.theta) & (track.t >= 0.0))
    t, theta = track.t, np.unwrap(track.theta)
    last = np.searchsorted(t, t + WINDOW_S)
    first = np.flatnonzero(last < len(t))
    last = last[first]
    whole = np.concatenate([[0], np.cumsum(gaps(track))]) if len(t) else np.zeros(0)
    first, last = (ends[whole[first] == whole[last]] for ends in (first, last))
    first, last = (ends[t[last] - t[first] < 1.5 * WINDOW_S] for ends in (first, last))
    time = t[last] - t[first]
    middle, half = 0.5 * (theta[last] + theta[first]), 0.5 * (theta[last] - theta[first])
    dx, dy = track.x[last] - track.x[first], track.y[last] - track.y[first]
    arc = (dx * np.cos(middle) + dy * np.sin(middle)) / np.sinc(half / np.pi)
    overlap = max(1.0, float(np.median(last - first))) if len(first) else 1.0
    return Steps(t[first], t[last], np.array([arc, 2.0 * half]) / time, overlap)


_TWISTS = ('geometry_msgs/msg/TwistStamped', 'geometry_msgs/msg/Twist')
_BY_NEARNESS = (topics.CMD_VEL_GUARDED, topics.CMD_VEL)
_LONGEST_WAY_S = 0.5
_SAME = 1e-6


@dataclass(frozen=True)
class Drive:
    """Commands and motion of one robot.

    Attributes:
        commands: Rows t (s), V (m/s), omega (rad/s), each held until the next one, shape (3, K),
            of the topic nearest to the base that has a command that moves it.
        wheels: Its motion from its wheels; None if not recorded.
        way: Delay from the law to that topic in s; 0 if unknown.
    """

    commands: Floats
    seen: FleetTable
    wheels: FleetTable | None = None
    way: float = 0.0


def drives(path: Path, warn: Callable[[str], None]) -> dict[int, Drive]:
    """Return commands and motion of the robots of a run, by their numbers; `warn` prints losses.

    Raises:
        SetcmasError: There is no run, or its commands were not recorded.
    """
    bag = find_run(path).recording
    found = _recorded(bag, warn) if bag else {}
    if not found:
        raise SetcmasError(
            f"'{path}' has no robot with both commands and motion; its bag must contain "
            f'{topics.robot_topic(1, topics.CMD_VEL)} and odometry'
        )
    return found


def _recorded(path: Path, warn: Callable[[str], None]) -> dict[int, Drive]:
    from setcmas_tools.bags.bag_reader import open_bag  # CSV files are read without rosbags

    with open_bag(path) as bag:
        named = [(topic.name, topic.msgtype) for topic in bag.topics]
        seen = FleetSamples(named)
        has_mocap = any(name.startswith('/mocap/') for name, _ in named)
        wheels = FleetSamples(row for row in named if not row[0].startswith('/mocap/'))
        twists = {name: array('d') for name, kind in named if kind in _TWISTS}
        takers: dict[BagTopic, list[Taker]] = {}
        for topic in bag.topics:
            own_takers = [one.collector(topic.name) for one in (seen, *([wheels] * has_mocap))]
            takers[topic] = [taker for taker in own_takers if taker]
            if topic.name in twists:
                takers[topic].append(partial(_take_twist, twists[topic.name]))
        bag.deliver(takers, bag.first_command())
        for notice in bag.notices:
            warn(notice)
    table, own = seen.table(), wheels.table() if has_mocap else None
    if table is None:
        return {}
    rows = {name: np.array(row).reshape(-1, 3).T for name, row in twists.items()}
    return {
        robot: drive
        for robot in table.robots
        if (drive := _drive(robot, rows, table.of(robot), own and own.of(robot)))
    }


def _take_twist(rows: array[float], time_ns: int, message: Any) -> None:
    twist = getattr(message, 'twist', message)
    rows.extend((time_ns / 1e9, twist.linear.x, twist.angular.z))


def _drive(
    robot: int, twists: dict[str, Floats], seen: FleetTable, wheels: FleetTable | None
) -> Drive | None:
    named = [topics.robot_topic(robot, name) for name in _BY_NEARNESS]
    recorded = [topic for topic in named if topic in twists and twists[topic].size]
    # Where the base receives cmd_vel itself, its guard only ever stops it.
    moving = [topic for topic in recorded if twists[topic][1:].any()]
    if not recorded:
        return None
    topic = (moving or recorded)[0]
    wanted = twists.get(topics.robot_topic(robot, topics.CMD_VEL_WANTED))
    way = 0.0 if wanted is None else _way(wanted, twists[topic])
    known = wheels if wheels is not None and len(wheels.t) else None
    return Drive(twists[topic], seen, known, way)


def _way(wanted: Floats, sent: Floats) -> float:
    """Return the median delay in s from the command of a law to its topic; 0 if never sent."""
    ways = []
    for t, V, omega in wanted[:, np.any(wanted[1:] != 0.0, axis=0)].T:
        first, last = np.searchsorted(sent[0], (t, t + _LONGEST_WAY_S))
        same = np.hypot(sent[1, first:last] - V, sent[2, first:last] - omega) < _SAME
        if same.any():
            ways.append(float(sent[0, first + np.argmax(same)] - t))
    return float(np.median(ways)) if ways else 0.0
