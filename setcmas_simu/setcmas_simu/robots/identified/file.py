"""Model file: gains, lags and delays of the robots of a lab, for `--model model.yaml`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import yaml

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.robots.identified.model import LONGEST_DELAY_S, IdentifiedRobot, Response
from setcmas_simu.robots.velocity_limits import MODELS, limits_named
from setcmas_simu.yaml_entries import Entry, read_entries

ENDINGS = ('.yaml', '.yml')
OTHERS = 'others'
"""Key for the robots that the file does not name."""

_MOST_GAIN = 10.0
_ROWS = ('forward', 'turn', 'way')


@dataclass(frozen=True)
class ModelFile:
    """Content of a model file.

    Attributes:
        robots: Models by robot number.
        others: Model of all other robots; None if there is none.
        limits: Name of the velocity limits of commands.
        path: The file; None if it is not written yet.
    """

    robots: Mapping[int, IdentifiedRobot]
    others: IdentifiedRobot | None = None
    limits: str = 'ideal'
    path: Path | None = None

    def robot(self, number: int) -> IdentifiedRobot:
        """Return the model of a robot.

        Raises:
            SetcmasError: The file has no model of this robot.
        """
        found = self.robots.get(number, self.others)
        if found is None:
            names = ', '.join(map(robot_name, self.robots))
            raise SetcmasError(
                f"'{self.path}' has no model of {robot_name(number)}, only of {names}; add it, or "
                f"add '{OTHERS}' for all other robots"
            )
        return found


def read_model_file(path: Path) -> ModelFile:
    """Read a model file.

    Raises:
        SetcmasError: The file cannot be read, or is invalid.
    """
    fields = read_entries(path).fields(('limits', 'robots', OTHERS))
    limits = fields['limits'].choice(MODELS) if 'limits' in fields else 'ideal'
    others = _robot(fields[OTHERS], limits) if OTHERS in fields else None
    named = fields['robots'].value if 'robots' in fields else {}
    if not isinstance(named, dict):
        raise fields['robots'].mistake('a mapping with the numbers of robots')
    if not named and others is None:
        raise SetcmasError(f"'{path}' has no robots; add 'robots' or '{OTHERS}'")
    robots = {_number(key, entry): _robot(entry, limits) for key, entry in named.items()}
    return ModelFile(robots, others, limits, path)


def write_model_file(content: ModelFile, path: Path, remark: str) -> None:
    """Write a model file for `read_model_file`; `remark` becomes its first line.

    Raises:
        SetcmasError: The file cannot be written.
    """
    entries: dict[str, Any] = {'limits': content.limits}
    entries['robots'] = {number: _entries(one) for number, one in content.robots.items()}
    if content.others:
        entries[OTHERS] = _entries(content.others)
    text = yaml.safe_dump(entries, sort_keys=False, default_flow_style=None)
    try:
        path.write_text(f'# {remark}\n{text}', encoding='utf-8')
    except OSError as error:
        raise SetcmasError(f"'{path}' cannot be written: {error.strerror}") from error


def _entries(robot: IdentifiedRobot) -> dict[str, Any]:
    rows = {'forward': asdict(robot.forward), 'turn': asdict(robot.turn)}
    rounded = {name: {k: round(v, 4) for k, v in row.items()} for name, row in rows.items()}
    return {**rounded, 'way': round(robot.way, 4)}


def _number(key: str, entry: Entry) -> int:
    if not (key.isdecimal() and int(key) >= 1):
        raise entry.error(f"invalid robot '{key}'; must be a whole number from 1")
    return int(key)


def _robot(entry: Entry, limits: str) -> IdentifiedRobot:
    fields = entry.fields(_ROWS)
    forward, turn = (_response(fields[r]) if r in fields else Response() for r in _ROWS[:2])
    way = fields['way'].number(least=0.0, most=LONGEST_DELAY_S) if 'way' in fields else 0.0
    return IdentifiedRobot(forward, turn, limits_named(limits), way)


def _response(entry: Entry) -> Response:
    given = entry.fields(('gain', 'lag', 'delay'))
    bounds = {
        'gain': {'above': 0.0, 'most': _MOST_GAIN},
        'lag': {'least': 0.0, 'most': LONGEST_DELAY_S},
        'delay': {'least': 0.0, 'most': LONGEST_DELAY_S},
    }
    return Response(**{name: value.number(**bounds[name]) for name, value in given.items()})
