"""Options that choose the lab, for all processes of an experiment."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

from setcmas_ctrl.filter.filter_options import FILTERS
from setcmas_expe.lab.lab import Lab, Mocap
from setcmas_expe.lab.lab_file import DEFAULT_FILE, load_lab
from setcmas_expe.mocap.sources import MOCAP_SOURCES
from setcmas_simu.errors import SetcmasError
from setcmas_simu.option_groups import Options, flag, option
from setcmas_simu.option_kinds import ACCELERATION, LENGTH, NB_ROBOTS, Kind, OneOf, PathTo
from setcmas_simu.robots.arena import FORM, Arena, Borders, Obstacles, ObstaclesKind
from setcmas_simu.robots.model import ROBOT_LIMITS


@dataclass(frozen=True, kw_only=True)
class LabChoice(Options):
    """Which lab it is, and which of its checks are off."""

    TITLE: ClassVar[str] = 'lab'

    lab: Path | None = option(
        PathTo(),
        'lab file, with the default fleet, arena and safety filter of the experiment',
        default=None,
        default_text='the lab file of the package',
    )
    mocap: str | None = option(
        Kind(metavar='NAME'),
        'motion capture driver (see setcmas list)',
        default=None,
    )
    without_guard: bool = flag(
        'allow robots without a cmd_vel_guard; they keep moving if this machine or the network '
        'dies'
    )
    without_motion_check: bool = flag(
        'switch off the check that robots move as commanded, which also proves their identity'
    )


@dataclass(frozen=True, kw_only=True)
class ExperimentOptions(LabChoice):
    """The lab of a scenario."""

    emulate: bool = flag(
        'an experiment in an emulated lab on this machine, with all safety functions and no '
        'hardware'
    )


@dataclass(frozen=True, kw_only=True)
class LabOptions(LabChoice):
    """Which lab it is; options override the lab file."""

    nb_robots: int | None = option(
        NB_ROBOTS, 'size of the fleet', default=None, default_text="the lab file's, or 1"
    )
    limits: str | None = option(
        OneOf(tuple(ROBOT_LIMITS)), 'speed limits of the robots', default=None
    )
    arena: Arena | None = option(Borders(), 'borders of the arena (m)', default=None)
    min_separation: float | None = option(
        LENGTH, 'minimum distance between two robots', default=None
    )
    filter: str | None = option(
        OneOf(FILTERS), 'keep robots apart, in the arena and off obstacles', default=None
    )
    obstacles: str | None = option(ObstaclesKind(), f'obstacles to avoid: {FORM}', default=None)
    accel: float | None = option(ACCELERATION, 'largest forward acceleration', default=None)

    def chosen(self) -> Lab:
        """Return the lab.

        Raises:
            SetcmasError: The lab file has a mistake, or a name does not suit motion capture.
        """
        lab = load_lab(self.lab or DEFAULT_FILE, self.nb_robots)
        names = ('arena', 'min_separation', 'filter', 'accel')
        given = {name: getattr(self, name) for name in names}
        given['mocap'] = _mocap(self.mocap, lab) if self.mocap else None
        given['limits'] = ROBOT_LIMITS[self.limits] if self.limits else None
        given['obstacles'] = Obstacles.of(self.obstacles) if self.obstacles else None
        chosen = replace(
            lab,
            guarded=not self.without_guard,
            checks_motion=lab.checks_motion and not self.without_motion_check,
            **{name: value for name, value in given.items() if value is not None},
        )
        if chosen.lidar_stop and not chosen.guarded:
            raise SetcmasError(
                '--without-guard: the lab file sets lidar_stop, for which robots need their guards'
            )
        missing = [robot.number for robot in chosen.robots if not robot.start]
        if chosen.mocap.source.from_start and missing:
            raise SetcmasError(
                f'{chosen.mocap.preset} counts from start poses: measure them, and write them '
                f'into the lab file, such as {{number: {missing[0]}, start: [0.5, -1.0, 1.57]}}'
            )
        chosen.check_geometry()
        return chosen


def _mocap(name: str, lab: Lab) -> Mocap:
    source = MOCAP_SOURCES.get(name)
    for robot in lab.robots:
        if not source.may_name(robot.mocap_name):
            raise SetcmasError(
                f"--mocap {name}: mocap_name '{robot.mocap_name}' must be {source.body_must_be}"
            )
    return replace(lab.mocap, preset=name, source=source)
