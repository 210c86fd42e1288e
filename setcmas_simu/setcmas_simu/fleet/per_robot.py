"""Values per robot in one text: '1:leader.py,2-8:follower.py'."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import format_robots, parse_robots

_RANGE = r'\d+(?:-\d+)?'
_ROBOTS = rf'\s*({_RANGE}(?:\s*,\s*{_RANGE})*)\s*:'
_ENTRY = re.compile(rf'{_ROBOTS}(.*?)(?:,(?={_ROBOTS})|$)', re.DOTALL)


def is_per_robot(text: str) -> bool:
    """Return whether a text gives values per robot: it begins with robots and a colon.

    For a file whose own name begins like this, users type './1:name.py'.
    """
    return re.match(_ROBOTS, text) is not None


def parse_per_robot(text: str, option: str) -> dict[int, str]:
    """Return the value of each robot in a text such as '1:a,2-4:b' or '1,3:a,2:b'.

    A comma separates two values only if robots and a colon follow it; any other comma or colon
    is part of a value. Raises SetcmasError for other texts, with the name of the option.
    """
    values: dict[int, str] = {}
    for entry in _ENTRY.finditer(text):
        robots, value = entry[1], entry[2]
        if not value.strip():
            raise SetcmasError(
                f"{option} '{text}': '{robots}:' has no value; it must be ROBOTS:VALUE, "
                "such as '1:a,2-4:b'"
            )
        for robot in parse_robots(robots):
            if robot in values:
                raise SetcmasError(f"{option} '{text}' names robot {robot} twice")
            values[robot] = value.strip()
    return values


def format_per_robot(values: Mapping[int, str]) -> str:
    """Return the shortest text that `parse_per_robot` turns into these values."""
    robots_of: dict[str, list[int]] = {}
    for robot in sorted(values):
        robots_of.setdefault(values[robot], []).append(robot)
    return ','.join(f'{format_robots(robots)}:{value}' for value, robots in robots_of.items())


def mapped(text: str, change: Callable[[str], str], option: str) -> str:
    """Return a text with each value changed, whether it has values per robot or just one."""
    if not is_per_robot(text):
        return change(text)
    values = parse_per_robot(text, option)
    return format_per_robot({robot: change(value) for robot, value in values.items()})


def check_in_fleet(robots: Iterable[int], nb_robots: int, option: str) -> None:
    """Raise SetcmasError if an option names a robot outside the fleet."""
    if strangers := sorted(robot for robot in robots if not 1 <= robot <= nb_robots):
        raise SetcmasError(
            f'{option} names robot {strangers[0]}; the fleet has robots 1 to {nb_robots}'
        )
