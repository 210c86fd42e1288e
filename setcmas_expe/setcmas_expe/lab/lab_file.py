"""Lab files: YAML, checked with the line of each mistake; and options that override them."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import ClassVar

from setcmas_ctrl.filter.filter_options import FILTERS
from setcmas_expe.lab.lab import Lab, LabRobot, Mocap, Timeouts
from setcmas_expe.mocap import sources
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.option_groups import Options, flag, option
from setcmas_simu.option_kinds import (
    ACCELERATION,
    LENGTH,
    NB_ROBOTS,
    Kind,
    Number,
    OneOf,
    PathTo,
    Whole,
)
from setcmas_simu.plugins import PluginError
from setcmas_simu.robots.arena import FORM, Arena, Borders, Obstacles, ObstaclesKind
from setcmas_simu.robots.model import ROBOT_LIMITS, VelocityLimits
from setcmas_simu.yaml_entries import Entry, read_entries

DEFAULT_FILE = Path(str(resources.files('setcmas_expe') / 'config' / 'lab.yaml'))
"""The lab file with all defaults and a comment on each."""

_GROUPS = {
    'mocap': ('preset', 'topic', 'type', 'y_up'),
    'arena': ('x', 'y'),
    'timeouts': ('pose', 'command', 'pause'),
    'safety': ('motion_check', 'lidar_stop'),
    'joystick': ('button', 'topic'),
    'network': ('static_peers',),
}
_VALUES = ('robots', 'min_separation', 'obstacles', 'filter', 'limits', 'accel')
_KEYS = (*_GROUPS, *_VALUES)
_ROBOT = ('number', 'mocap_name', 'namespace')
_START = 'start'
_LIMITS = {'forward': 3.0, 'turn': 20.0, 'wheel': 3.0, 'wheel_separation': 2.0}
"""Keys of limits, and the largest plausible values indoors (m/s, rad/s, m/s, m)."""
_TIMEOUT = Number(least=0.3, most=2.0, unit='s')  # commands come every 0.2 s
_POSITIVE = Number(above=0, finite=True)
_NAMESPACE = re.compile(r'[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*')
_TOPIC = re.compile(r'(/[A-Za-z][A-Za-z0-9_]*)+')
_ADDRESS = re.compile(r'[A-Za-z0-9_.:-]+')


def load_lab(path: Path, nb_robots: int | None = None) -> Lab:
    """Return the lab in a file, completed by the default file.

    So many of its robots take part, all by default. Without a list of robots in the file, any
    number may, by default 1.

    Raises:
        SetcmasError: The file has a mistake; the message names file and line.
    """
    given = read_entries(path).fields(_KEYS)
    defaults = read_entries(DEFAULT_FILE).fields(_KEYS)
    groups = {name: _group(name, given, defaults) for name in _GROUPS}
    chosen = defaults | given
    mocap = _mocap(groups['mocap'])
    limits = _limits(chosen['limits'])
    arena = Arena(*_interval(groups['arena']['x']), *_interval(groups['arena']['y']))
    lab = Lab(
        robots=_robots(given.get('robots'), nb_robots, mocap.source),
        mocap=mocap,
        arena=arena,
        min_separation=float(_POSITIVE.of(chosen['min_separation'])),
        obstacles=Obstacles.listed(chosen['obstacles']),
        filter=OneOf(FILTERS).of(chosen['filter']),
        limits=limits,
        accel=_POSITIVE.of(given['accel']) if 'accel' in given else math.inf,
        timeouts=Timeouts(
            *(float(_TIMEOUT.of(groups['timeouts'][key])) for key in _GROUPS['timeouts'])
        ),
        checks_motion=groups['safety']['motion_check'].flag(),
        lidar_stop=groups['safety']['lidar_stop'].flag(),
        guarded=True,
        joystick_button=Whole().of(groups['joystick']['button']),
        joystick_topic=_checked(
            groups['joystick']['topic'], _TOPIC.fullmatch, 'a topic, such as /joy'
        ),
        static_peers=tuple(
            _checked(peer, _ADDRESS.fullmatch, 'an address, such as 192.168.1.21')
            for peer in groups['network']['static_peers'].items()
        ),
    )
    with chosen['min_separation'].located():
        lab.check_separation()
    return lab


def _group(name: str, given: dict[str, Entry], defaults: dict[str, Entry]) -> dict[str, Entry]:
    keys = _GROUPS[name]
    return defaults[name].fields(keys) | (given[name].fields(keys) if name in given else {})


def _robots(
    entry: Entry | None, nb_robots: int | None, source: sources.MocapSource
) -> tuple[LabRobot, ...]:
    if entry is None:
        return tuple(LabRobot.numbered(i) for i in range(1, (nb_robots or 1) + 1))
    by_number: dict[int, LabRobot] = {}
    for item in entry.items():
        robot = _robot(item, source)
        for other, key in itertools.product(by_number.values(), _ROBOT):
            if (value := getattr(robot, key)) == getattr(other, key):
                raise item.error(f"two robots have the {key} '{value}'; each robot needs its own")
        by_number[robot.number] = robot
    numbers = sorted(by_number)
    if not numbers or numbers[-1] != len(numbers):
        raise entry.error(
            f'the robots have the numbers {numbers}; they must be 1 to N without a gap'
        )
    if nb_robots and nb_robots > len(numbers):
        raise entry.error(
            f'the lab has {len(numbers)} robots; --nb-robots {nb_robots} asks for more'
        )
    return tuple(by_number[number] for number in numbers[:nb_robots])


def _robot(entry: Entry, source: sources.MocapSource) -> LabRobot:
    fields = entry.fields((*_ROBOT, _START))
    if 'number' not in fields:
        raise entry.mistake('a robot with a number, such as {number: 1, mocap_name: tb3_1}')
    number = Whole(1).of(fields['number'])
    names = {'mocap_name': robot_name(number), 'namespace': robot_name(number)}
    letters = f'a name of letters, digits and _, such as {robot_name(number)}'
    for key, accepts, expected in (
        ('mocap_name', source.may_name, source.body_must_be),
        ('namespace', _NAMESPACE.fullmatch, letters),
    ):
        if key in fields:
            names[key] = _checked(fields[key], accepts, expected)
    return LabRobot(number, **names, start=_start(fields[_START]) if _START in fields else None)


def _start(entry: Entry) -> tuple[float, float, float]:
    values = [item.number() for item in entry.items()]
    if len(values) != 3:
        raise entry.mistake('x, y in m and the heading in rad, such as [0.5, -1.0, 1.57]')
    return values[0], values[1], values[2]


def _mocap(fields: dict[str, Entry]) -> Mocap:
    name = OneOf((*sources.MOCAP_SOURCES.plugins(), sources.CUSTOM)).of(fields['preset'])
    try:
        source = _custom(fields) if name == sources.CUSTOM else sources.MOCAP_SOURCES.get(name)
    except PluginError as error:
        raise fields['preset'].error(str(error)) from error
    if 'topic' in fields:
        try:
            topic = sources.check_topic(fields['topic'].text(), source.per_body)
        except SetcmasError as error:
            raise fields['topic'].error(f'{fields["topic"].name}: {error}') from None
        source = replace(source, topic=topic)
    if 'type' in fields:
        if not source.per_body:
            raise fields['type'].mistake(f'left out: {name} has its own type')
        message_type, read = sources.STANDARD[OneOf(tuple(sources.STANDARD)).of(fields['type'])]
        source = replace(source, message_type=message_type, read=read)
    return Mocap(name, source, fields['y_up'].flag())


def _custom(fields: dict[str, Entry]) -> sources.MocapSource:
    """Return a source whose topic and type the lab file sets."""
    missing = [key for key in ('topic', 'type') if key not in fields]
    if missing:
        known = ', '.join(sources.MOCAP_SOURCES.plugins())
        raise fields['preset'].mistake(
            f'a preset ({known}), or custom together with mocap.{missing[0]}'
        )
    return sources.per_body(f'/{sources.NAME}', sources.POSE_STAMPED)


def _interval(entry: Entry) -> tuple[float, float]:
    ends = [end.number() for end in entry.items()]
    if len(ends) != 2 or ends[0] >= ends[1]:
        raise entry.error(
            f'{entry.name} is {ends}; it must be two numbers '
            'in m, the smaller one first, such as [-3.0, 3.0]'
        )
    return ends[0], ends[1]


def _limits(entry: Entry) -> VelocityLimits:
    fields = entry.fields(_LIMITS) if isinstance(entry.value, dict) else {}
    if limits := ROBOT_LIMITS.get(str(entry.plain())):
        return limits
    if len(fields) < len(_LIMITS):
        expected = f'{", ".join(ROBOT_LIMITS)}, or a mapping with {", ".join(_LIMITS)}'
        raise entry.mistake(expected, ROBOT_LIMITS)
    return VelocityLimits(*(Number(above=0, most=_LIMITS[key]).of(fields[key]) for key in _LIMITS))


def _checked(entry: Entry, accepts: Callable[[str], object], expected: str) -> str:
    text = entry.text()
    if not accepts(text):
        raise entry.mistake(expected)
    return text


@dataclass(frozen=True, kw_only=True)
class LabChoice(Options):
    """Which lab it is, and which of its checks are off."""

    TITLE: ClassVar[str] = 'lab'

    lab: Path | None = option(
        PathTo(),
        'lab file: its fleet, arena and safety filter are the defaults here',
        default=None,
        default_text='the one that comes with setcmas',
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
        given['mocap'] = _chosen_mocap(self.mocap, lab) if self.mocap else None
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


def _chosen_mocap(name: str, lab: Lab) -> Mocap:
    source = sources.MOCAP_SOURCES.get(name)
    for robot in lab.robots:
        if not source.may_name(robot.mocap_name):
            raise SetcmasError(
                f"--mocap {name}: mocap_name '{robot.mocap_name}' must be {source.body_must_be}"
            )
    return replace(lab.mocap, preset=name, source=source)
