"""Gain, lag and delay of each robot of a run, the model file and the table that they make."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.robots.identified_robot import (
    IdentifiedRobot,
    ModelFile,
    Response,
    read_model_file,
)
from setcmas_simu.robots.model import MODELS, limits_named
from setcmas_simu.robots.models import is_model_file
from setcmas_simu.table import Table
from setcmas_tools.compare.response_fit import Fit, HeldCommand, Measured, fitted
from setcmas_tools.compare.robot_drive import Drive, Steps, drives, steps_of
from setcmas_tools.run.run import Run

FORWARD, TURN = 'forward speed', 'turn rate'
_POSES, _WHEELS = 'poses', 'wheels'
_LEAST_WINDOWS = 20


@dataclass(frozen=True)
class Channel:
    """What a run tells of one speed of a robot.

    Attributes:
        fit: Gain, lag and delay, as far as they are told.
        told_by: What lag and delay were measured with: poses or wheels.
        age: By how much later poses show a motion than wheels in s; 0 without wheels.
        measured: The speed as poses show it.
    """

    fit: Fit
    told_by: str
    age: float
    measured: Measured


@dataclass(frozen=True)
class Identified:
    """What a run tells of one robot.

    Attributes:
        channels: Forward speed and turn rate, by name.
        responses: What the model has for each; None if the run does not tell how it moves.
        way: Time in s that commands need to the robot, and poses from it, beside its own delay.
    """

    channels: Mapping[str, Channel]
    responses: Mapping[str, Response] | None
    way: float


def identify(path: Path, warn: Callable[[str], None]) -> dict[int, Identified]:
    """Return what a run tells of its robots, by their numbers.

    Raises:
        SetcmasError: There is no run, or its commands were not recorded.
    """
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


def _channel(command: HeldCommand, row: int, seen: Steps, wheels: Steps | None) -> Channel:
    """Return a channel: the gain as poses show it, lag and delay from the wheels if they tell."""
    measured = _measured(command, seen, row)
    if wheels and len(wheels.begin) >= _LEAST_WINDOWS:
        own = fitted(_measured(command, wheels, row))
        if own.tells_times:
            fit = fitted(measured, lag=own.response.lag)
            age = max(0.0, fit.response.delay - own.response.delay)
            told = Fit(
                replace(own.response, gain=fit.response.gain),
                replace(own.errors, gain=fit.errors.gain),
                fit.quality,
            )
            return Channel(told, _WHEELS, age, measured)
    return Channel(fitted(measured), _POSES, 0.0, measured)


def _measured(command: HeldCommand, steps: Steps, row: int) -> Measured:
    return Measured(command, steps.begin, steps.end, steps.speeds[row], steps.overlap)


def _responses(channels: Mapping[str, Channel]) -> dict[str, Response] | None:
    """Return the responses of a model: the same wheels make both speeds, so one tells the other.

    A channel whose lag and delay are not told has those of the other, and gain 1 if that is not
    told either.
    """
    told = [one.fit.response for one in channels.values() if one.fit.tells_times]
    if not told:
        return None
    found = {}
    for name in (FORWARD, TURN):
        fit = channels[name].fit
        gain = fit.response.gain if fit.tells_gain else 1.0
        times = fit.response if fit.tells_times else told[0]
        found[name] = replace(times, gain=gain)
    return found


def model_of(found: Mapping[int, Identified], limits: str) -> ModelFile | None:
    """Return the model of the robots that a run tells of; None if there are none.

    Robots of other numbers have the medians of theirs. `limits` is the name of what they may be
    commanded.
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
    """Return the name of what robots of a run may be commanded, as its lab or its model tells it.

    Returns:
        None if neither does, and it was an experiment, in which there always are limits.
    """
    told = run.parameters.get('limits')
    known = {name for name, limits in MODELS.items() if told in (name, asdict(limits))}
    if model := run.parameters.get('model'):
        files = [one.path for one in run.inputs if one.option == 'model']
        known |= {read_model_file(path).limits for path in files if is_model_file(path.name)}
        known |= {model} & MODELS.keys()
    return next(iter(known - {'ideal'}), None if run.tables.safety else 'ideal')


_HEADS = ('robot', 'speed', 'gain', 'lag (s)', 'delay (s)', 'fit (%)', 'measured with')
_UNKNOWN = '?'
_GOOD_FIT = 70.0


def identified_table(found: Mapping[int, Identified]) -> str:
    """Return a row for each speed of each robot, with standard errors, ? for what is not told."""
    rows = [
        [robot_name(robot), name, *_cells(channel)]
        for robot, one in found.items()
        for name, channel in one.channels.items()
    ]
    return str(Table(rows, _HEADS, 'llrrrrl'))


def _cells(channel: Channel) -> list[str]:
    fit, response, errors = channel.fit, channel.fit.response, channel.fit.errors
    gain = f'{response.gain:.3f} ± {errors.gain:.3f}' if fit.tells_gain else _UNKNOWN
    times = [(response.lag, errors.lag), (response.delay, errors.delay)]
    told = [f'{t:.3f} ± {e:.3f}' if fit.tells_times else _UNKNOWN for t, e in times]
    return [gain, *told, f'{max(0.0, fit.quality):.0f}', channel.told_by]


def identified_notes(found: Mapping[int, Identified]) -> Iterator[str]:
    """Yield a line for each thing that the run does not tell, or tells badly."""
    for robot, one in found.items():
        name = robot_name(robot)
        if not one.channels:
            yield f'{name}: its motion was recorded for too short a time to tell anything'
        vague = [speed for speed, channel in one.channels.items() if not channel.fit.tells_times]
        if one.channels and one.responses is None:
            yield (
                f'{name}: its commands change too little to tell how it follows them, or it did '
                'not follow them; let it start, stop and turn more often'
            )
        elif vague:
            yield (
                f'{name}: its {" and ".join(vague)} changes too little to tell lag and delay; the '
                'model has those of its other speed, for the same wheels make both'
            )
        poor = [
            speed
            for speed, channel in one.channels.items()
            if channel.fit.tells_gain and channel.fit.quality < _GOOD_FIT
        ]
        if poor:
            yield (
                f'{name}: the model explains less than {_GOOD_FIT:g} % of its {" and ".join(poor)}'
                '; a pause, contact or slip may be why, and ± does not tell of these'
            )
