"""The spheres that control scripts drew, `drawings.csv`."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

from setcmas_ctrl.drawing import Sphere
from setcmas_tools.run.fleet_motion import read_rows, write_lines

DRAWINGS_FILE = 'drawings.csv'
MARKER, TRAIL = 'marker', 'trail'
_COLUMNS = (
    't', 'robot', 'name', 'kind', 'x', 'y', 'z', 'diameter', 'red', 'green', 'blue', 'alpha'
)  # fmt: skip
_DIGITS = 9


class Drawing(NamedTuple):
    """A sphere that a script drew.

    Attributes:
        t: When, in s from the first command of the run.
        robot: The robot that it was drawn for.
        name: Of its topic, such as 'wp_ref'.
        kind: MARKER, which takes the place of the last one of this robot and name, or TRAIL.
        sphere: Where it is, and how it looks.
    """

    t: float
    robot: int
    name: str
    kind: str
    sphere: Sphere


class DrawingRecord:
    """Collects drawings: a canvas for scripts that run without ROS.

    A marker that stays as it is counts once, however often it is drawn.

    Attributes:
        t: The time now, in s.
    """

    def __init__(self) -> None:
        """Start without any drawing."""
        self.t = 0.0
        self._drawings: list[Drawing] = []
        self._shown: dict[tuple[int, str], Sphere] = {}

    def show(self, robot: int, name: str, sphere: Sphere) -> None:
        """Note a marker that is drawn now."""
        if self._shown.get((robot, name)) != sphere:
            self._shown[robot, name] = sphere
            self._drawings.append(Drawing(self.t, robot, name, MARKER, sphere))

    def extend_trail(self, robot: int, name: str, sphere: Sphere) -> None:
        """Note a sphere that is added to a trail now."""
        self._drawings.append(Drawing(self.t, robot, name, TRAIL, sphere))

    def drawings(self, start: float = 0.0) -> list[Drawing]:
        """Return what was drawn, sorted by time, then robot.

        Args:
            start: The time that is t = 0, in s.
        """
        moved = [d._replace(t=d.t - start) for d in self._drawings] if start else self._drawings
        return sorted(moved, key=itemgetter(0, 1))  # by time, then by robot


class DrawnOverTime:
    """What the scripts of a run drew, by time.

    Attributes:
        shown: The drawings that can be seen, sorted by time.
    """

    def __init__(self, drawings: Iterable[Drawing]) -> None:
        """Take drawings sorted by time; those that are not finite show nothing."""
        self.shown = [drawing for drawing in drawings if _is_finite(drawing.sphere)]
        self._markers: dict[tuple[int, str], list[Drawing]] = {}
        self._trails: list[Drawing] = []
        for drawing in self.shown:
            if drawing.kind == MARKER:
                self._markers.setdefault((drawing.robot, drawing.name), []).append(drawing)
            else:
                self._trails.append(drawing)

    def markers(self, t: float) -> list[Drawing]:
        """Return the markers that are seen at a time in s."""
        last = ((own, bisect_right(own, t, key=itemgetter(0))) for own in self._markers.values())
        return [own[count - 1] for own, count in last if count]

    def trails(self, t: float, since: float = -math.inf) -> list[Drawing]:
        """Return by what trails grew until a time in s, from after another one on."""
        first, last = (bisect_right(self._trails, at, key=itemgetter(0)) for at in (since, t))
        return self._trails[first:last]


def _is_finite(sphere: Sphere) -> bool:
    return all(map(math.isfinite, (*sphere[:4], *sphere.colour, sphere.alpha)))


def write_drawings(drawings: Iterable[Drawing], path: Path) -> None:
    """Write drawings: t with 6 decimals, other numbers with 9 significant digits.

    Raises:
        OSError: The file cannot be written.
    """
    write_lines(path, _COLUMNS, map(_line, drawings))


def _line(d: Drawing) -> str:
    x, y, z, diameter, colour, alpha = d.sphere
    numbers = ','.join(f'{n:.{_DIGITS}g}' for n in (x, y, z, diameter, *colour, alpha))
    return f'{d.t:.6f},{d.robot},{d.name},{d.kind},{numbers}\n'


def read_drawings(path: Path) -> list[Drawing]:
    """Read drawings; none if there is no such file.

    Raises:
        SetcmasError: The file cannot be read or is damaged.
    """
    return read_rows(path, _COLUMNS, lambda cells: _drawing(*cells)) or []


def _drawing(t: str, robot: str, name: str, kind: str, *numbers: str) -> Drawing:
    x, y, z, diameter, red, green, blue, alpha = map(float, numbers)
    sphere = Sphere(x, y, z, diameter, (red, green, blue), alpha)
    return Drawing(float(t), int(robot), name, kind, sphere)
