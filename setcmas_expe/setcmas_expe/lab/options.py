"""Options that choose the lab of an experiment, for all its processes."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

from setcmas_expe.arena import Arena
from setcmas_expe.lab.file import DEFAULT_FILE, load_lab
from setcmas_expe.lab.model import Lab, Mocap
from setcmas_expe.mocap.sources import MOCAP_SOURCES
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import AUTO, CMD_VEL_TYPES
from setcmas_simu.options.completion import names_and_files
from setcmas_simu.options.group import Options, option
from setcmas_simu.options.kinds import NB_ROBOTS, Kind, Number, OneOf, PathTo, Whole
from setcmas_simu.robots.velocity_limits import ROBOT_MODELS


@dataclass(frozen=True)
class _Borders(Kind):
    """Borders of an arena."""

    metavar: str | None = field(default='XMIN,XMAX,YMIN,YMAX', kw_only=True)

    @property
    def must_be(self) -> str:
        """The form, and an example."""
        return 'XMIN,XMAX,YMIN,YMAX in m, the smaller ones first, such as --arena=-2,2,-1.5,1.5'

    def parse(self, text: str) -> Arena | str:
        """Return the arena that a text tells."""
        try:
            arena = Arena(*map(float, text.split(',')))
        except (TypeError, ValueError):
            return text
        return arena if self.accepts(arena) else text

    def accepts(self, value: Any) -> bool:
        """Return whether a value is an arena that has a size."""
        if not isinstance(value, Arena):
            return False
        finite = all(map(math.isfinite, astuple(value)))
        return finite and value.xmin < value.xmax and value.ymin < value.ymax

    def text(self, value: Any) -> str:
        """Return the borders."""
        return ','.join(map(repr, astuple(value)))


@dataclass(frozen=True, kw_only=True)
class LabOptions(Options):
    """Which lab it is; options override the lab file."""

    TITLE: ClassVar[str] = 'lab'

    lab: Path | None = option(
        PathTo(), 'lab file', default=None, default_text='the one that comes with this'
    )
    nb_robots: int | None = option(
        NB_ROBOTS, 'size of the fleet', default=None, default_text="the lab file's, or 1"
    )
    mocap: str | None = option(
        Kind(metavar='NAME'),
        'motion capture driver (see setcmas list)',
        default=None,
        complete=names_and_files(MOCAP_SOURCES.offers),
    )
    limits: str | None = option(
        OneOf(tuple(ROBOT_MODELS)), 'how fast robots are driven', default=None
    )
    arena: Arena | None = option(_Borders(), 'where robots may be (m)', default=None)
    min_separation: float | None = option(
        Number(above=0, unit='m', finite=True), 'between two robots, in m', default=None
    )
    cmd_vel_type: str | None = option(
        OneOf((AUTO, *CMD_VEL_TYPES)), 'what the robots listen to', default=None
    )
    joystick_button: int | None = option(
        Whole(metavar='B'), 'starts and pauses, counted from 0', default=None
    )

    def chosen(self) -> Lab:
        """Return the lab.

        Raises:
            SetcmasError: The lab file has a mistake, or names do not suit its motion capture.
        """
        lab = load_lab(self.lab or DEFAULT_FILE, self.nb_robots)
        if self.mocap:
            lab = replace(lab, mocap=_mocap(self.mocap, lab))
        if self.limits:
            lab = replace(lab, limits=ROBOT_MODELS[self.limits])
        names = ('arena', 'min_separation', 'cmd_vel_type', 'joystick_button')
        given = {name: getattr(self, name) for name in names}
        return replace(lab, **{name: value for name, value in given.items() if value is not None})


def _mocap(name: str, lab: Lab) -> Mocap:
    source = MOCAP_SOURCES.get(name)
    for robot in lab.robots:
        if not source.may_name(robot.mocap_name):
            raise SetcmasError(
                f"--mocap {name}: mocap_name '{robot.mocap_name}' must be letters, digits and _ "
                f'to be part of the topic {source.topic}'
            )
    return replace(lab.mocap, preset=name, source=source)
