"""Gain, lag and delay of each robot of a run, the model file and the table that they make."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from tabulate import tabulate

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.robots.identified_robot import (
    IdentifiedRobot,
    ModelFile,
    Response,
    read_model_file,
)
from setcmas_simu.robots.model import LIMITS, limits_named
from setcmas_simu.robots.models import is_model_file
from setcmas_tools.compare.response_fit import Fit, HeldCommand, MeasuredSpeeds, fitted
from setcmas_tools.compare.robot_drive import Drive, Steps, drives, steps_of
from setcmas_tools.run.run import Run

FORWARD, TURN = 'forward speed', 'turn rate'
_POSES, _WHEELS = 'poses', 'wheels'
_LEAST_WINDOWS = 20


@dataclass(frozen=True)
class SpeedResponse:
    """Identified response of one speed of a robot.

    Attributes:
        fit: Gain, lag and delay.
        measured_with: Source of lag and delay: poses or wheels.
        age: Delay of poses to wheels in s; 0 without wheels.
    """

    fit: Fit
    measured_with: str
    age: float


@dataclass(frozen=True)
class Identified:
    """Identified responses of a robot.

    Attributes:
        channels: Forward speed and turn rate, by name.
        responses: Responses for the model; None if the run does not determine them.
        way: Delay in s of commands to the robot and poses from it, apart from its own.
    """

    channels: Mapping[str, SpeedResponse]
    responses: Mapping[str, Response] | None
    way: float


def identify(path: Path, warn: Callable[[str], None]) -> dict[int, Identified]:
    """Identify the robots of a run, by their numbers, or raise SetcmasError."""
    return {robot: _identified(drive) for robot, drive in drives(path, warn).items()}


def _identified(drive: Drive) -> Identified:
    seen = steps_of(drive.seen)
    wheels = steps_of(drive.wheels) if drive.wheels else None
    channels = {}
    for row, name in enumerate((FORWARD, TURN)):
        command = HeldCommand(drive.commands[0], drive.commands[1 + row])
        if len(seen.begin) >= _LEAST_WINDOWS:
            channels[name] = _channel(command, row, seen, wheels)
    age = float(np.mean([one.age for one in channels.values()])) if channels else 0.0
    return Identified(channels, _responses(channels), drive.way + age)


def _channel(command: HeldCommand, row: int, seen: Steps, wheels: Steps | None) -> SpeedResponse:
    """Return a channel: the gain from poses, lag and delay from the wheels if possible."""
    measured = _measured(command, seen, row)
    if wheels and len(wheels.begin) >= _LEAST_WINDOWS:
        own = fitted(_measured(command, wheels, row))
        if own.times_known:
            fit = fitted(measured, lag=own.response.lag)
            age = max(0.0, fit.response.delay - own.response.delay)
            fit = Fit(
                replace(own.response, gain=fit.response.gain),
                replace(own.errors, gain=fit.errors.gain),
                fit.quality,
            )
            return SpeedResponse(fit, _WHEELS, age)
    return SpeedResponse(fitted(measured), _POSES, 0.0)


def _measured(command: HeldCommand, steps: Steps, row: int) -> MeasuredSpeeds:
    return MeasuredSpeeds(command, steps.begin, steps.end, steps.speeds[row], steps.overlap)


def _responses(channels: Mapping[str, SpeedResponse]) -> dict[str, Response] | None:
    """Return the responses for a model; the same wheels make both speeds.

    A channel with unknown lag and delay takes those of the other; an unknown gain is 1.
    """
    known = [one.fit.response for one in channels.values() if one.fit.times_known]
    if not known:
        return None
    found = {}
    for name in (FORWARD, TURN):
        fit = channels[name].fit
        gain = fit.response.gain if fit.gain_known else 1.0
        times = fit.response if fit.times_known else known[0]
        found[name] = replace(times, gain=gain)
    return found


def model_of(found: Mapping[int, Identified], limits: str) -> ModelFile | None:
    """Return the model of the identified robots; None if there are none.

    Other robots have the medians of their values. `limits` names the limits of commands.
    """
    rows = {n: (one.responses, one.way) for n, one in found.items() if one.responses}
    robots = {
        number: _robot(responses[FORWARD], responses[TURN], limits, way)
        for number, (responses, way) in rows.items()
    }
    if not robots:
        return None
    responses = [(robot.forward, robot.turn) for robot in robots.values()]
    forward, turn = (Response(*_medians(list(one))) for one in zip(*responses, strict=True))
    way = float(np.median([robot.way for robot in robots.values()]))
    return ModelFile(robots, _robot(forward, turn, limits, way), limits)


def _robot(forward: Response, turn: Response, limits: str, way: float) -> IdentifiedRobot:
    return IdentifiedRobot(forward, turn, limits_named(limits), way)


def _medians(responses: list[Response]) -> list[float]:
    rows: Floats = np.array([[one.gain, one.lag, one.delay] for one in responses])
    medians: list[float] = np.median(rows, axis=0).tolist()
    return medians


def limits_of(run: Run) -> str | None:
    """Return the name of the limits of commands in a run, from its lab or its model.

    Returns:
        None if neither names them in an experiment, which always has limits.
    """
    given = run.parameters.get('limits')
    known = {name for name, limits in LIMITS.items() if given in (name, asdict(limits))}
    if model := run.parameters.get('model'):
        files = [one.path for one in run.inputs if one.option == 'model']
        known |= {read_model_file(path).limits for path in files if is_model_file(path.name)}
        known |= {model} & LIMITS.keys()
    return next(iter(known - {'ideal'}), None if run.tables.safety else 'ideal')


_HEADS = ('robot', 'speed', 'gain', 'lag (s)', 'delay (s)', 'way (s)', 'fit (%)', 'measured with')
_ALIGNED = (*['left'] * 2, *['right'] * 5, 'left')
_UNKNOWN = '?'
_GOOD_FIT = 70.0


def identified_table(found: Mapping[int, Identified]) -> str:
    """Return a row for each speed of each robot, with standard errors; ? where unknown."""
    rows = [
        [robot_name(robot), name, *_cells(channel, one.way)]
        for robot, one in found.items()
        for name, channel in one.channels.items()
    ]
    table: str = tabulate(rows, _HEADS, colalign=_ALIGNED, disable_numparse=True)
    return table


def _cells(channel: SpeedResponse, way: float) -> list[str]:
    fit, response, errors = channel.fit, channel.fit.response, channel.fit.errors
    gain = f'{response.gain:.3f} ± {errors.gain:.3f}' if fit.gain_known else _UNKNOWN
    times = [(response.lag, errors.lag), (response.delay, errors.delay)]
    shown = [f'{t:.3f} ± {e:.3f}' if fit.times_known else _UNKNOWN for t, e in times]
    return [gain, *shown, f'{way:.3f}', f'{max(0.0, fit.quality):.0f}', channel.measured_with]


def identified_notes(found: Mapping[int, Identified]) -> Iterator[str]:
    """Yield a line for each value that the run does not determine, or determines badly."""
    for robot, one in found.items():
        name = robot_name(robot)
        if not one.channels:
            yield f'{name}: its motion was recorded for too short a time'
        vague = [speed for speed, channel in one.channels.items() if not channel.fit.times_known]
        if one.channels and one.responses is None:
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
            speed
            for speed, channel in one.channels.items()
            if channel.fit.gain_known and channel.fit.quality < _GOOD_FIT
        ]
        if poor:
            yield (
                f'{name}: the model explains less than {_GOOD_FIT:g} % of its {" and ".join(poor)}'
                '; a pause, a collision or slip may be the cause, which ± does not include'
            )
