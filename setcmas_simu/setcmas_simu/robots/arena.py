"""The arena and its obstacles: 'disc 1 2 0.5; polygon 0 0 1 0 1 1'."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import combinations
from numbers import Real
from typing import Any, NamedTuple

from setcmas_simu.errors import SetcmasError
from setcmas_simu.option_kinds import Kind, ParsedText
from setcmas_simu.yaml_entries import Entry


class Arena(NamedTuple):
    """The box in which robots may move, in m."""

    xmin: float
    xmax: float
    ymin: float
    ymax: float

    def distance(self, x: float, y: float) -> float:
        """Return how far a point (m) is from the box, in m; 0 inside."""
        return math.hypot(
            max(self.xmin - x, 0.0, x - self.xmax), max(self.ymin - y, 0.0, y - self.ymax)
        )

    def outward_normals(self, x: float, y: float) -> list[tuple[float, float]]:
        """Return the outward unit normal of each side that a point (m) is beyond."""
        sides = (
            (x > self.xmax, (1.0, 0.0)),
            (x < self.xmin, (-1.0, 0.0)),
            (y > self.ymax, (0.0, 1.0)),
            (y < self.ymin, (0.0, -1.0)),
        )
        return [normal for beyond, normal in sides if beyond]


@dataclass(frozen=True)
class Borders(Kind):
    """Borders of an arena as an option."""

    metavar: str | None = field(default='XMIN,XMAX,YMIN,YMAX', kw_only=True)

    must_be = 'XMIN,XMAX,YMIN,YMAX in m, minimum first, such as --arena=-2,2,-1.5,1.5'

    def value(self, given: Any) -> Any:
        """Return four borders, or those in a text, as an arena."""
        ends = given
        if isinstance(given, str):
            with suppress(ValueError):
                ends = [float(end) for end in given.split(',')]
        return Arena(*map(float, ends)) if self.accepts(ends) else given

    def accepts(self, value: Any) -> bool:
        """Return whether a value has the four borders of a box of positive size."""
        if not isinstance(value, Sequence) or len(value) != 4:
            return False
        if not all(isinstance(end, Real) and math.isfinite(end) for end in value):
            return False
        xmin, xmax, ymin, ymax = value
        return bool(xmin < xmax and ymin < ymax)


Point = tuple[float, float]
Side = tuple[Point, Point]

FORM = "'disc X Y RADIUS; polygon X1 Y1 X2 Y2 X3 Y3 ...' in m"


class Disc(NamedTuple):
    """A disc, in m."""

    x: float
    y: float
    radius: float


@dataclass(frozen=True)
class Polygon:
    """A polygon, in m: its corners in order, each once; its sides do not meet elsewhere."""

    corners: tuple[Point, ...]

    @property
    def sides(self) -> list[Side]:
        """The sides, from corner to corner."""
        return list(zip(self.corners, (*self.corners[1:], self.corners[0]), strict=True))

    def contains(self, x: float, y: float) -> bool:
        """Return whether a point (m) is inside: a ray from it crosses an odd number of sides."""
        crossed = [
            x < x1 + (y - y1) * (x2 - x1) / (y2 - y1)
            for (x1, y1), (x2, y2) in self.sides
            if (y1 > y) != (y2 > y)
        ]
        return sum(crossed) % 2 == 1

    def check_sides(self, name: str) -> None:
        """Check that sides meet at their corners only; SetcmasError calls the polygon `name`."""
        for side, other in combinations(self.sides, 2):
            if _meet(side, other):
                (x1, y1), (x2, y2), (x3, y3), (x4, y4) = *side, *other
                raise SetcmasError(
                    f'{name}: the side from ({x1:g}, {y1:g}) to ({x2:g}, {y2:g}) crosses or '
                    f'touches that from ({x3:g}, {y3:g}) to ({x4:g}, {y4:g}); give the corners '
                    'in the order in which they follow each other around it'
                )


def _meet(side: Side, other: Side) -> bool:
    """Return whether two sides of a polygon have a point in common, other than a shared corner."""
    shared = {*side} & {*other}
    ends = [(end, other) for end in side] + [(end, side) for end in other]
    if any(end not in shared and _is_on(end, line) for end, line in ends):
        return True
    turns = [_turn(line, end) for end, line in ends]
    return turns[0] * turns[1] < 0.0 and turns[2] * turns[3] < 0.0


def _is_on(point: Point, side: Side) -> bool:
    (x1, x2), (y1, y2) = map(sorted, zip(*side, strict=True))
    within = x1 <= point[0] <= x2 and y1 <= point[1] <= y2
    return within and _turn(side, point) == 0.0


def _turn(side: Side, point: Point) -> float:
    """Return a number above 0 if a point is to the left of a side, below 0 if to the right."""
    (x1, y1), (x2, y2) = side
    return (x2 - x1) * (point[1] - y1) - (y2 - y1) * (point[0] - x1)


@dataclass(frozen=True)
class Obstacles:
    """Discs and polygons that robots must not touch."""

    discs: tuple[Disc, ...] = ()
    polygons: tuple[Polygon, ...] = ()

    @classmethod
    def of(cls, text: str) -> Obstacles:
        """Read obstacles from a text, which may be empty, or raise SetcmasError."""
        shapes = [_shape_of(part) for part in text.split(';') if part.strip()]
        return cls._sorted(shapes)

    @classmethod
    def listed(cls, entry: Entry) -> Obstacles:
        """Read obstacles from a list such as `- disc: [x, y, radius]`, or raise SetcmasError."""
        return cls._sorted([_shape_listed(item) for item in entry.items()])

    @classmethod
    def _sorted(cls, shapes: Sequence[Disc | Polygon]) -> Obstacles:
        return cls(
            tuple(shape for shape in shapes if isinstance(shape, Disc)),
            tuple(shape for shape in shapes if isinstance(shape, Polygon)),
        )

    def contain(self, x: float, y: float) -> bool:
        """Return whether a point (m) is inside an obstacle."""
        in_disc = (math.hypot(x - disc.x, y - disc.y) < disc.radius for disc in self.discs)
        return any(in_disc) or any(polygon.contains(x, y) for polygon in self.polygons)

    def __str__(self) -> str:
        """Return the obstacles as text that `of` reads."""
        texts = [f'disc {_written(disc)}' for disc in self.discs]
        texts += [f'polygon {_written(_flat(polygon.corners))}' for polygon in self.polygons]
        return '; '.join(texts)


@dataclass(frozen=True)
class ObstaclesKind(ParsedText):
    """Obstacles as text; in YAML also as a list."""

    read_text: Callable[[str], object] = Obstacles.of
    form: str = FORM
    metavar: str | None = field(default='SHAPES', kw_only=True)

    def read(self, entry: Entry, place: Callable[[str], str]) -> Any:
        """Return the obstacles of a text or a list."""
        if isinstance(entry.value, list):
            return str(Obstacles.listed(entry))
        return super().read(entry, place)

    def check(self, name: str, value: Any) -> None:
        """Check that a value is valid obstacle text."""
        if isinstance(value, str):
            Obstacles.of(value)  # has the more precise message
        super().check(name, value)


def _shape_of(text: str) -> Disc | Polygon:
    kind, *words = text.split()
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    return _shape(kind, numbers, f"obstacle '{text.strip()}'")


def _shape_listed(entry: Entry) -> Disc | Polygon:
    fields = entry.fields(('disc', 'polygon'))
    if len(fields) != 1:
        raise entry.mistake('one disc: [x, y, radius] or one polygon: [[x, y], ...]')
    ((kind, shape),) = fields.items()
    numbers = [number for item in shape.items() for number in _numbers(item)]
    return _shape(kind, numbers, f'{shape.file}, line {shape.line}: {shape.name}')


def _numbers(entry: Entry) -> list[float]:
    if isinstance(entry.value, list):
        return [item.number() for item in entry.items()]
    return [entry.number()]


def _shape(kind: str, numbers: Sequence[float], name: str) -> Disc | Polygon:
    if not all(map(math.isfinite, numbers)):
        raise SetcmasError(f'{name}: coordinates must be finite')
    if kind == 'disc' and len(numbers) == 3 and numbers[2] > 0:
        return Disc(*numbers)
    if kind == 'polygon' and len(numbers) >= 6 and len(numbers) % 2 == 0:
        corners = tuple(zip(numbers[::2], numbers[1::2], strict=True))
        if len({*corners}) < len(corners):  # a side without a length has no direction
            raise SetcmasError(f'{name} has the same corner twice; remove one')
        polygon = Polygon(corners)
        polygon.check_sides(name)
        return polygon
    if kind == 'disc' and len(numbers) == 2:
        raise SetcmasError(f'{name} has no radius; write disc X Y RADIUS, such as disc 1 2 0.5')
    raise SetcmasError(
        f'invalid {name}; must be a disc (x, y, radius above 0) or a polygon (x and y of at '
        'least 3 corners), such as disc 1 2 0.5'
    )


def _flat(corners: Sequence[Point]) -> Iterator[float]:
    return (number for corner in corners for number in corner)


def _written(numbers: Iterator[float] | Sequence[float]) -> str:
    return ' '.join(repr(number).removesuffix('.0') for number in numbers)
