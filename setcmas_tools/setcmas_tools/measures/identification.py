"""Gain, lag and delay of each robot of a run, the model file and the table that they make."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from tabulate import tabulate

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.robots.identified_robot import (
    IdentifiedRobot,
    ModelFile,
    Response,
    read_model_file,
)
from setcmas_simu.robots.model import LIMITS, ROBOT_LIMITS, limits_named
from setcmas_simu.robots.models_by_name import is_model_file
from setcmas_tools.measures.response_fit import Fit, MeasuredSpeeds, fitted
from setcmas_tools.run.fleet_motion import FleetTable, gaps
from setcmas_tools.run.run import Run

FORWARD, TURN = 'forward speed', 'turn rate'
WINDOW_S = 0.2
"""Time over which speeds are means: poses that are a little wrong make speeds very wrong."""

_LEAST_WINDOWS = 20
_TWISTS = ('geometry_msgs/msg/TwistStamped', 'geometry_msgs/msg/Twist')
_BY_NEARNESS = (topics.CMD_VEL_GUARDED, topics.CMD_VEL)


@dataclass(frozen=True)
class Identified:
    """Identified responses of a robot.

    Attributes:
        fits: Those of forward speed and turn rate, by name; empty for too short a motion.
        responses: Responses for the model; None if the run does not determine them.
    """

    fits: Mapping[str, Fit]
    responses: Mapping[str, Response] | None


def identify(run: Run, warn: Callable[[str], None]) -> dict[int, Identified]:
    """Identify the robots of a run, by their numbers; `warn` prints losses of its bag.

    Raises:
        SetcmasError: The commands of the run were not recorded.
    """
    found = {}
    for robot, sent in recorded_commands(run, warn).items():
        fits = {
            name: fitted(speeds)
            for name, speeds in measured_speeds(sent, run.table.of(robot)).items()
            if len(speeds.begin) >= _LEAST_WINDOWS
        }
        found[robot] = Identified(fits, _responses(fits))
    return found


def recorded_commands(run: Run, warn: Callable[[str], None]) -> dict[int, Floats]:
    """Return the commands of the robots of a run, by their numbers.

    Returns:
        Rows t (s), V (m/s), omega (rad/s), each held until the next one, shape (3, K), of the
        topic nearest to the base that has a command that moves it.

    Raises:
        SetcmasError: They were not recorded.
    """
    from setcmas_tools.bags.bag_reader import open_bag  # CSV files are read without rosbags

    twists: dict[str, array[float]] = {}
    if run.bag:
        with open_bag(run.bag) as bag:
            of_topics = {topic: array('d') for topic in bag.topics if topic.msgtype in _TWISTS}
            bag.deliver({topic: [partial(_take_twist, row)] for topic, row in of_topics.items()})
            for notice in bag.notices:
                warn(notice)
        twists = {topic.name: row for topic, row in of_topics.items()}
    commands = {name: np.array(row).reshape(-1, 3).T for name, row in twists.items() if row}
    found = {}
    for robot in run.robots:
        named = [topics.robot_topic(robot, name) for name in _BY_NEARNESS]
        recorded = [commands[topic] for topic in named if topic in commands]
        # Where the base receives cmd_vel itself, its guard only ever stops it.
        moving = [rows for rows in recorded if rows[1:].any()]
        if recorded:
            found[robot] = (moving or recorded)[0]
    if not found:
        source = f"'{run.bag}'" if run.bag else 'this run, without a bag,'
        raise SetcmasError(
            f'{source} has no robot with both commands and motion; its bag must contain '
            f'{topics.robot_topic(1, topics.CMD_VEL)} and odometry'
        )
    return found


def _take_twist(rows: array[float], time_ns: int, message: Any) -> None:
    twist = getattr(message, 'twist', message)
    rows.extend((time_ns / 1e9, twist.linear.x, twist.angular.z))


def measured_speeds(commands: Floats, track: FleetTable) -> dict[str, MeasuredSpeeds]:
    """Return forward speed (m/s) and turn rate (rad/s) of a robot, and its commands.

    They are means over windows of `WINDOW_S`, one from each pose on. The forward way is the arc
    whose chord joins two poses, with the heading of its middle:
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
    sent, V, omega = commands
    return {
        name: MeasuredSpeeds(sent, u, t[first], t[last], moved / time, overlap)
        for name, u, moved in ((FORWARD, V, arc), (TURN, omega, 2.0 * half))
    }


def _responses(fits: Mapping[str, Fit]) -> dict[str, Response] | None:
    """Return the responses for a model; the same wheels make both speeds.

    A speed with unknown lag and delay takes those of the other; an unknown gain is 1.
    """
    known = [fit.response for fit in fits.values() if fit.times_known]
    if not known:
        return None
    found = {}
    for name, fit in fits.items():
        gain = fit.response.gain if fit.gain_known else 1.0
        times = fit.response if fit.times_known else known[0]
        found[name] = replace(times, gain=gain)
    return found


def model_of(found: Mapping[int, Identified], limits: str) -> ModelFile | None:
    """Return the model of the identified robots; None if there are none.

    Other robots have the medians of their values. `limits` names the limits of commands.
    """
    robots = {
        number: IdentifiedRobot(one.responses[FORWARD], one.responses[TURN], limits_named(limits))
        for number, one in found.items()
        if one.responses
    }
    if not robots:
        return None
    forward = _median([robot.forward for robot in robots.values()])
    turn = _median([robot.turn for robot in robots.values()])
    return ModelFile(robots, IdentifiedRobot(forward, turn, limits_named(limits)), limits)


def _median(responses: list[Response]) -> Response:
    rows: Floats = np.array([[one.gain, one.lag, one.delay] for one in responses])
    return Response(*np.median(rows, axis=0).tolist())


def limits_of(run: Run) -> str | None:
    """Return the name of the velocity limits of a run's robots; None where it names none."""
    model, given = (run.parameters.get(name) for name in ('model', 'limits'))
    for one in run.inputs:
        if one.option == 'model' and is_model_file(one.path.name):
            return read_model_file(one.path).limits
    if model in ROBOT_LIMITS:
        return str(model)
    known = (name for name, limits in LIMITS.items() if given in (name, asdict(limits)))
    return next(known, None)


_HEADS = ('robot', 'speed', 'gain', 'lag (s)', 'delay (s)', 'fit (%)')
_ALIGNED = (*['left'] * 2, *['right'] * 4)
_UNKNOWN = '?'
_GOOD_FIT = 70.0


def identified_table(found: Mapping[int, Identified]) -> str:
    """Return a row for each speed of each robot, with standard errors; ? where unknown."""
    rows = [
        [topics.robot_name(robot), name, *_cells(fit)]
        for robot, one in found.items()
        for name, fit in one.fits.items()
    ]
    table: str = tabulate(rows, _HEADS, colalign=_ALIGNED, disable_numparse=True)
    return table


def _cells(fit: Fit) -> list[str]:
    response, errors = fit.response, fit.errors
    gain = f'{response.gain:.3f} ± {errors.gain:.3f}' if fit.gain_known else _UNKNOWN
    times = [(response.lag, errors.lag), (response.delay, errors.delay)]
    shown = [f'{t:.3f} ± {e:.3f}' if fit.times_known else _UNKNOWN for t, e in times]
    return [gain, *shown, f'{max(0.0, fit.quality):.0f}']


def identified_notes(found: Mapping[int, Identified]) -> Iterator[str]:
    """Yield a line for each value that the run does not determine, or determines badly."""
    for robot, one in found.items():
        name = topics.robot_name(robot)
        if not one.fits:
            yield f'{name}: its motion was recorded for too short a time'
        vague = [speed for speed, fit in one.fits.items() if not fit.times_known]
        if one.fits and one.responses is None:
            yield (
                f'{name}: its commands change too little to identify it, or it did not follow '
                'them; let it start, stop and turn more often'
            )
        elif vague:
            yield (
                f'{name}: its {" and ".join(vague)} changes too little to identify lag and delay; '
                'the model uses those of its other speed, since the same wheels make both'
            )
        poor = [
            speed for speed, fit in one.fits.items() if fit.gain_known and fit.quality < _GOOD_FIT
        ]
        if poor:
            yield (
                f'{name}: the model explains less than {_GOOD_FIT:g} % of its {" and ".join(poor)}'
                '; a pause, a collision or slip may be the cause; ± does not include this error'
            )
