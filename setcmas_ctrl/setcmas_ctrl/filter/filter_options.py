"""Options of the safety filter, the arena and the obstacles, and verdicts of the filter."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from setcmas_simu.option_groups import Options, option, spelled
from setcmas_simu.option_kinds import ACCELERATION, Number, OneOf
from setcmas_simu.robots.arena import FORM, Borders, ObstaclesKind

NONE, BARRIER = FILTERS = ('none', 'barrier')

SEPARATION_M = 0.45
"""Default minimum distance of two robots' centres for poses of this instant.

Over ROS poses are up to 0.1 s old, in which two robots come 0.1 m closer at 0.5 m/s each: 0.35 m
are left, as in the default lab file.
"""

LOOKAHEAD_M = 0.05
"""Distance of a unicycle's control point ahead of its axle."""


@dataclass(frozen=True, kw_only=True)
class FilterOptions(Options):
    """Safety filter, arena and obstacles."""

    TITLE: ClassVar[str] = 'safety filter'

    filter: str | None = option(
        OneOf(FILTERS),
        'keep robots apart, in the arena and off obstacles',
        default=None,
        default_text=NONE,
    )
    min_separation: float | None = option(
        Number(above=2.0 * LOOKAHEAD_M, unit='m', finite=True),  # points must not pass each other
        'minimum distance between the centres of two robots',
        default=None,
        default_text=f'{SEPARATION_M:g} m',
    )
    gamma: float = option(
        Number(above=0, unit='1/s', finite=True),
        'barrier gain: the larger it is, the faster robots may approach each other',
        default=1.0,
    )
    arena: Sequence[float] | None = option(
        Borders(), 'region that robots must not leave (m)', default=None
    )
    obstacles: str | None = option(
        ObstaclesKind(),
        f'obstacles to avoid: {FORM}; plots and videos show them',
        default=None,
    )
    accel: float | None = option(
        ACCELERATION, 'largest acceleration (braking is not limited)', default=None
    )

    @property
    def is_on(self) -> bool:
        """Whether the filter is on."""
        return self.filter == BARRIER

    @property
    def notes(self) -> list[str]:
        """Notes on options that have no effect without the filter."""
        of_filter = ('min_separation', 'gamma', 'arena')
        idle = [spelled(name) for name in self.changed() if name in of_filter]
        if self.filter is not None or not idle:
            return []
        return [f'ignored without the filter: {", ".join(idle)}; add --filter barrier']


class Verdict(enum.IntEnum):
    """What the safety filter did with a wanted velocity; z of cmd_cart_vel_allowed holds it."""

    KEPT = 0
    """The velocity is safe: the robot drives as without a filter, but within its limits."""

    CHANGED = 1
    """The filter chose another velocity for the control point, ahead of a unicycle's axle."""

    NO_SOLUTION = 2
    """No velocity is safe: the robot stops."""
