"""Robots identified from an experiment: gain, lag and delay of each; `--model model.yaml`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.option_kinds import MAX_RATE_HZ, Number, OneOf
from setcmas_simu.robots import unicycle
from setcmas_simu.robots.model import IDEAL, LIMITS, RobotModel, VelocityLimits, limits_named
from setcmas_simu.robots.unicycle import BURGER_SHAPE
from setcmas_simu.yaml_entries import Entry, read_entries

LONGEST_DELAY_S = 2.0
"""Largest delay of a robot that can be modelled."""

_LAGS = slice(6, 8)  # rows of a state after POSE and TWIST: the current speeds


@dataclass(frozen=True)
class Response:
    """How a speed follows its command: lag w' = gain u(t - delay) - w.

    Attributes:
        gain: Steady-state speed divided by the commanded speed.
        lag: Time constant in s; 0 is none.
        delay: Time in s between a command and its first effect.
    """

    gain: float = 1.0
    lag: float = 0.0
    delay: float = 0.0


class IdentifiedRobot(RobotModel):
    """Unicycle whose forward speed and turn rate each have a gain, a lag and a delay.

    A step solves the first-order lag with dead time (Astrom and Hagglund, Advanced PID Control,
    2006, section 2.4) for piecewise constant commands; the robot moves at its mean speeds.
    """

    shape = BURGER_SHAPE

    def __init__(self, forward: Response, turn: Response, limits: VelocityLimits = IDEAL) -> None:
        """Describe the robot."""
        self.forward, self.turn, self.limits = forward, turn, limits
        self.V_max = limits.V_max * max(1.0, forward.gain)
        delays = [forward.delay, turn.delay]
        self._slots = 2 + math.ceil(MAX_RATE_HZ * max(delays))  # commands may change at each step
        self._delays = np.array(delays)[:, None]
        self._gains = np.array([forward.gain, turn.gain])
        self._lags = np.maximum([forward.lag, turn.lag], 1e-9)

    def start(self, poses: Floats) -> Floats:
        """Return the states of robots at rest, whose earlier commands were zero."""
        states = np.zeros((8 + 3 * self._slots, poses.shape[1]))
        states[:3] = poses
        ages, _ = self._remembered(states)
        ages[:] = math.inf
        return states

    def step(self, states: Floats, commands: Floats, Ts: float) -> Floats:
        """Return the states one period later."""
        later = states.copy()
        ages, remembered = self._remembered(later)
        # On the same curve within the limits, as the cmd_vel bridge does in an experiment.
        wanted = commands[[0, 2]].T.tolist()
        slower = np.transpose([self.limits.scaled_down(V, omega) for V, omega in wanted])
        self._remember(ages, remembered, slower)
        means = np.empty((2, states.shape[1]))
        for row, (delay, gain, lag) in enumerate(
            zip(self._delays, self._gains, self._lags, strict=True)
        ):
            # Slot k, newest first, acts from begin[k] to end[k] of this period.
            begin = np.clip(delay - ages, 0.0, Ts)
            begin[-1] = 0.0
            end = np.vstack([np.full((1, begin.shape[1]), Ts), begin[:-1]])
            wanted = gain * remembered[row]
            before = states[_LAGS][row]
            shares = np.exp((end - Ts) / lag) - np.exp((begin - Ts) / lag)
            speed = before * math.exp(-Ts / lag) + np.sum(shares * wanted, axis=0)
            means[row] = (np.sum((end - begin) * wanted, axis=0) - lag * (speed - before)) / Ts
            later[_LAGS][row] = speed
        ages += Ts
        return unicycle.driven(later, means[0], means[1], Ts)

    def _remembered(self, states: Floats) -> tuple[Floats, Floats]:
        """Return views of the commands' ages in s, (K, N), and of their speeds, (2, K, N)."""
        ages, speeds = np.split(states[8:], [self._slots])
        return ages, speeds.reshape(2, self._slots, -1)

    def _remember(self, ages: Floats, remembered: Floats, commands: Floats) -> None:
        """Store commands, shape (2, N), that differ from the newest stored ones."""
        new = np.any(remembered[:, 0] != commands, axis=0)
        ages[1:, new], remembered[:, 1:, new] = ages[:-1, new], remembered[:, :-1, new]
        ages[0, new], remembered[:, 0, new] = 0.0, commands[:, new]


ENDINGS = ('.yaml', '.yml')
OTHERS = 'others'
"""Key for the robots that the file does not name."""

_MOST_GAIN = 10.0
_ROWS = ('forward', 'turn')


@dataclass(frozen=True)
class ModelFile:
    """Content of a model file: models by robot number, and that of all others.

    `limits` is the name of the limits of commands; `path` is None if the file is not written yet.
    """

    robots: Mapping[int, IdentifiedRobot]
    others: IdentifiedRobot | None = None
    limits: str = 'ideal'
    path: Path | None = None

    def robot(self, number: int) -> IdentifiedRobot:
        """Return the model of a robot, or raise SetcmasError if there is none."""
        found = self.robots.get(number, self.others)
        if found is None:
            names = ', '.join(map(robot_name, self.robots))
            raise SetcmasError(
                f"'{self.path}' has no model of {robot_name(number)}, only of {names}; add it, or "
                f"add '{OTHERS}' for all other robots"
            )
        return found


def read_model_file(path: Path) -> ModelFile:
    """Read a model file, or raise SetcmasError with file and line."""
    fields = read_entries(path).fields(('limits', 'robots', OTHERS))
    limits = OneOf(tuple(LIMITS)).of(fields['limits']) if 'limits' in fields else 'ideal'
    others = _robot(fields[OTHERS], limits) if OTHERS in fields else None
    named = fields['robots'].value if 'robots' in fields else {}
    if not isinstance(named, dict):
        raise fields['robots'].mistake('a mapping with the numbers of robots')
    if not named and others is None:
        raise SetcmasError(f"'{path}' has no robots; add 'robots' or '{OTHERS}'")
    robots = {_number(key, entry): _robot(entry, limits) for key, entry in named.items()}
    return ModelFile(robots, others, limits, path)


def write_model_file(content: ModelFile, path: Path, remark: str) -> None:
    """Write a model file whose first line is a remark, or raise SetcmasError."""
    entries: dict[str, Any] = {'limits': content.limits}
    entries['robots'] = {number: _entries(one) for number, one in content.robots.items()}
    if content.others:
        entries[OTHERS] = _entries(content.others)
    text = yaml.safe_dump(entries, sort_keys=False, default_flow_style=None)
    with file_errors(f"'{path}' cannot be written"):
        path.write_text(f'# {remark}\n{text}', encoding='utf-8')


def _entries(robot: IdentifiedRobot) -> dict[str, Any]:
    rows = {'forward': asdict(robot.forward), 'turn': asdict(robot.turn)}
    return {name: {k: round(v, 4) for k, v in row.items()} for name, row in rows.items()}


def _number(key: str, entry: Entry) -> int:
    if not (key.isdecimal() and int(key) >= 1):
        raise entry.error(f"invalid robot '{key}'; must be a whole number from 1")
    return int(key)


_DELAY = Number(least=0, most=LONGEST_DELAY_S, unit='s')


def _robot(entry: Entry, limits: str) -> IdentifiedRobot:
    fields = entry.fields(_ROWS)
    forward, turn = (_response(fields[r]) if r in fields else Response() for r in _ROWS)
    return IdentifiedRobot(forward, turn, limits_named(limits))


def _response(entry: Entry) -> Response:
    given = entry.fields(('gain', 'lag', 'delay'))
    kinds = {'gain': Number(above=0, most=_MOST_GAIN), 'lag': _DELAY, 'delay': _DELAY}
    return Response(**{name: kinds[name].of(value) for name, value in given.items()})
