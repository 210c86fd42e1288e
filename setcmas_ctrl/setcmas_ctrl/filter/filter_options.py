"""Options of the safety filter, and of what it keeps robots from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from setcmas_simu.options.group import ClashError, Options, option, spelled
from setcmas_simu.options.kinds import ACCELERATION, LENGTH, Number, OneOf
from setcmas_simu.robots.arena import Borders, ObstaclesKind

NONE, BARRIER = FILTERS = ('none', 'barrier')
TURN = 'turn'

OF_LAB = ('filter', 'min_separation', 'arena', 'obstacles', 'accel')
"""The options that a lab file has, too."""

SEPARATION_M = 0.35
"""Least distance of two robots' centres unless told: that of the lab file that comes with this."""

GAMMA = 1.0
LOOKAHEAD_M = 0.05


@dataclass(frozen=True, kw_only=True)
class FilterOptions(Options):
    """What changes the velocities that control laws want, and keeps robots from each other."""

    TITLE: ClassVar[str] = 'safety filter'

    filter: str | None = option(
        OneOf(FILTERS),
        'keeps robots apart, in the arena and off obstacles',
        default=None,
        default_text=f"{NONE}; in experiments the lab file's",
    )
    deadlock: str = option(
        OneOf((NONE, TURN)), 'what robots do that block each other', default=NONE
    )
    min_separation: float | None = option(
        LENGTH,
        'least distance between the centres of two robots',
        default=None,
        default_text=f"{SEPARATION_M:g} m; in experiments the lab file's",
    )
    gamma: float = option(
        Number(above=0, unit='1/s', finite=True),
        'how fast robots may use up the distance that is left',
        default=GAMMA,
    )
    lookahead: float = option(
        LENGTH,
        'how far ahead of its axle a unicycle is kept from others',
        default=LOOKAHEAD_M,
    )
    arena: Sequence[float] | None = option(Borders(), 'where robots may be (m)', default=None)
    obstacles: str | None = option(
        ObstaclesKind(), 'what robots must not touch, drawn in plots and films', default=None
    )
    accel: float | None = option(
        ACCELERATION, 'how fast the speed of a robot may rise', default=None
    )

    @property
    def is_on(self) -> bool:
        """Whether robots are filtered."""
        return self.filter == BARRIER

    @property
    def notes(self) -> list[str]:
        """What to say of options that robots do not keep to without the filter."""
        of_filter = ('min_separation', 'gamma', 'lookahead', 'arena')
        idle = [spelled(name) for name in self.changed() if name in of_filter]
        if self.filter is not None or not idle:
            return []
        return [
            f'robots do not keep to {" and ".join(idle)} without the filter; add --filter barrier'
        ]

    def check(self) -> None:
        """See that what needs the filter has it."""
        if self.deadlock != NONE and not self.is_on:
            raise ClashError(
                '{} has an effect with {} barrier only; add that', 'deadlock', 'filter'
            )
