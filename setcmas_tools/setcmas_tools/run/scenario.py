"""Scenario of a run: its laws, robots, communication, safety, time and lab."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path
from typing import Any, ClassVar

from setcmas_ctrl.communication.communication_options import (
    CommunicationOptions,
    Condition,
    check_communication,
)
from setcmas_ctrl.filter.barrier_constraints import check_starts
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.laws.control_options import Algo, GivenConversion, LawOptions
from setcmas_ctrl.laws.script_search import LawScripts, unfilled_note
from setcmas_expe.lab.lab_file import ExperimentOptions
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, file_errors, it_must_be
from setcmas_simu.fleet.fleet import format_per_robot
from setcmas_simu.fleet.start_poses import parse_pose_option, poses_of_array
from setcmas_simu.option_groups import ClashError, Option, Options, option, plain
from setcmas_simu.option_kinds import DURATION
from setcmas_simu.robots.models_by_name import NO_LIMITS, check_models, model_names
from setcmas_simu.simulation_options import ClockOptions, RobotOptions
from setcmas_simu.yaml_entries import Entry, read_entries, write_yaml
from setcmas_tools.run.scenario_files import (
    OF_FILES,
    built_in_name,
    named_in,
    placed_in,
    robots_by_text,
)

VERSION = 1
"""Version of the keys of scenario files."""

OF_RUN = 'scenario'
"""The key of run.yaml that holds a scenario."""


@dataclass(frozen=True, kw_only=True)
class TimeOptions(ClockOptions):
    """Duration of a run, and the pace of simulated time."""

    duration: float = option(DURATION, 'length of the run, from the first command', default=40.0)


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """A run to be made, checked here.

        scenario = Scenario.load('square.yaml')
        run = simulate(scenario.replace(loss=0.3, set={'K': 2}))

    The names of its values are those of the options of `setcmas run`, in files and in Python.

    Attributes:
        law: The control laws, their settings, and how robots follow them.
        robots: The robots, their start poses, limits and rates.
        communication: Graph, links with their losses and delays, and triggering conditions.
        safety: The safety filter: distances between robots, arena and obstacles.
        time: Duration, and real or scaled time.
        lab: The lab of an experiment, emulated or real.
    """

    law: LawOptions
    robots: RobotOptions = field(default_factory=RobotOptions)
    communication: CommunicationOptions = field(default_factory=CommunicationOptions)
    safety: FilterOptions = field(default_factory=FilterOptions)
    time: TimeOptions = field(default_factory=TimeOptions)
    lab: ExperimentOptions = field(default_factory=ExperimentOptions)

    PARTS: ClassVar[Mapping[str, type[Options]]] = {
        'law': LawOptions,
        'robots': RobotOptions,
        'communication': CommunicationOptions,
        'safety': FilterOptions,
        'time': TimeOptions,
        'lab': ExperimentOptions,
    }

    @classmethod
    def of(cls, algo: Algo | Scenario, /, **values: Any) -> Scenario:
        """Return a scenario with values by name, or raise SetcmasError; others have defaults.

        Args:
            algo: A control law by name, a script, a function control(robotNo, nbRobots, poses, t),
                '1:leader.py,2-8:follower.py', or a dictionary with a law for each robot; or a
                scenario, whose other values stay.
            values: As in a scenario file. `poses` may be an array with rows x, y (m) and theta
                (rad); `graph` an adjacency matrix; `ctc` and `si_to_uni` a function, or one for
                each robot.
        """
        if isinstance(algo, Scenario):
            return algo.replace(**values)
        return cls(law=LawOptions(algo=_option('algo').value(algo))).replace(**values)

    @classmethod
    def load(cls, path: str | Path) -> Scenario:
        """Read a scenario file, or a run's run.yaml.

        Raises:
            SetcmasError: It has a mistake; the message names file and line.
        """
        content = read_entries(Path(path))
        if isinstance(content.value, dict) and OF_RUN in content.value:
            return cls.recorded(content.value[OF_RUN])
        return cls.read(content)

    @classmethod
    def recorded(cls, content: Entry, has_files: bool = True) -> Scenario:
        """Do the same as `read` for the entry of a run, maybe of an earlier version of setcmas.

        Values that this version does not have are left out.
        """
        values = content.value
        if isinstance(values, dict):
            values = {k: one for k, one in values.items() if k in ('version', *options())}
        return cls.read(replace(content, value=values), has_files=has_files)

    @classmethod
    def read(
        cls, content: Entry, base: Scenario | None = None, has_files: bool = True
    ) -> Scenario:
        """Return the scenario of a YAML entry, as changes to `base` or to the defaults.

        Files that it names are looked for, and read, if it `has_files`.

        Raises:
            SetcmasError: It has a mistake; the message names file and line.
        """
        entries = content.fields(('version', *options()))
        if 'version' in entries:
            with entries['version'].located():
                _check_version(entries['version'].value)
        exercise = 'exercise' in entries and entries['exercise'].flag()
        place = partial(placed_in, content.file.parent, exercise=exercise)
        given = {
            name: _option(name).read(entry, partial(place, name) if has_files else str)
            for name, entry in entries.items()
            if name != 'version' and entry.value is not None
        }
        if base is None and 'algo' not in given and has_files:
            raise content.error('there is no control law; add algo, such as algo: consensus')
        try:
            scenario = (base or cls(law=LawOptions(algo=given.get('algo', ''))))._with(given)
        except ClashError as error:
            named = next((entries[name] for name in error.names if name in entries), content)
            raise named.error(str(error)) from None
        for name, check in scenario._checks().items():
            if name in given and has_files:
                with entries[name].located():
                    check()
        return scenario

    def replace(self, **changes: Any) -> Scenario:
        """Return the same with other values by name, as for `of`, or raise SetcmasError."""
        given = {name: _option(name).value(value) for name, value in changes.items()}
        poses = given.get('poses')
        if poses is not None and not isinstance(poses, (Path, Mapping)):
            if given.get('random_poses'):
                raise ClashError('{} and {} both say where robots start', 'poses', 'random_poses')
            nb_robots = given.get('nb_robots', self.robots.nb_robots) or 1
            given['poses'] = poses_of_array(poses, nb_robots)
        return self._with(given)

    def _with(self, given: Mapping[str, Any]) -> Scenario:
        """Return the same with some values replaced by converted ones."""
        changed: dict[str, Any] = {}
        for name, part in self._parts():
            own = {key: value for key, value in given.items() if key in part.options()}
            changed[name] = replace(part, **own) if own else part
        return replace(self, **changed)

    def check(self) -> None:
        """Raise SetcmasError unless laws, models, graph and poses exist and suit the fleet."""
        for check in self._checks().values():
            check()

    def _checks(self) -> dict[str, Callable[[], object]]:
        """Return the checks that read files, by the name of the value."""
        law, robots, nb_robots = self.law, self.robots, self.robots.nb_robots
        own = CommunicationOptions(graph=self.communication.graph)
        models = model_names(robots.model, self.nb_robots)
        return {
            'algo': lambda: law.check_laws(nb_robots),
            'set': law.check_settings,
            'si_to_uni': law.check_conversion,
            'model': lambda: check_models(models, NO_LIMITS),
            'limits': lambda: check_models(models, robots.limits),
            'graph': lambda: check_communication(own, nb_robots),
            'ctc': lambda: check_communication(self.communication.found(law.exercise), nb_robots),
            'poses': lambda: robots.start_poses(self.nb_robots),
            'pose': lambda: robots.start_poses(self.nb_robots),
            'random_poses': lambda: robots.start_poses(self.nb_robots),
        }

    def _parts(self) -> Iterator[tuple[str, Options]]:
        return ((name, getattr(self, name)) for name in self.PARTS)

    @property
    def seed(self) -> int:
        """Seed of the random numbers of scripts, links and start poses."""
        return self.law.seed

    @property
    def nb_robots(self) -> int:
        """Number of robots in a simulation."""
        return self.robots.fleet_size

    def values(self) -> dict[str, Any]:
        """Return all values by name."""
        return {name: value for _, part in self._parts() for name, value in part.values().items()}

    def changed(self) -> dict[str, Any]:
        """Return the values by name that differ from their defaults."""
        return {k: v for _, part in self._parts() for k, v in part.changed().items()}

    def __repr__(self) -> str:
        """Return the values that differ from their defaults."""
        values = ', '.join(f'{name}={value!r}' for name, value in self.changed().items())
        return f'Scenario({values})'

    def found(self) -> Scenario:
        """Return the same with absolute paths of scripts and files, or raise SetcmasError."""
        law, conditions = self.law, self.communication.found(self.law.exercise)
        algo: Algo = law.algo
        if isinstance(algo, str):
            algo = law.scripts().text
        elif isinstance(algo, Mapping):
            algo = {i: one if callable(one) else _found(one, law) for i, one in algo.items()}
        found = replace(law, algo=algo, si_to_uni=law.conversion())
        same = replace(self, law=found, communication=conditions)
        return same.located(lambda name, text: text if name in _OF_FUNCTIONS else _absolute(text))

    @property
    def notes(self) -> list[str]:
        """Notes for the user, such as on scripts to be filled in; may raise SetcmasError."""
        laws = self.law.scripts().notes if self.law.is_scripts else []
        conditions = self.communication.found(self.law.exercise).notes
        conversion = self.law.conversion()
        unfilled = unfilled_note(conversion) if isinstance(conversion, Path) else ''
        return [*laws, *conditions, *filter(None, [unfilled])]

    @property
    def notes_on_simulation(self) -> list[str]:
        """The same, and that a simulated robot is alone; may raise SetcmasError."""
        is_alone = self.nb_robots == 1 and self.law.is_scripts and self.law.scripts().use_network
        size = 'set nb_robots to 5 (--nb-robots 5)'
        alone = f'the fleet has one robot, which has no neighbours; {size}'
        return [*self.notes, *([alone] if is_alone else [])]

    def overridden(self, typed: Mapping[str, Any]) -> Scenario:
        """Return this scenario with typed values; typed settings and single poses are added.

        Other start poses replace those of the scenario; another robot model brings its limits.

        Raises:
            SetcmasError: A value is invalid, or values contradict each other.
        """
        changes = dict(typed)
        if 'set' in typed:
            changes['set'] = {**self.law.set, **typed['set']}
        if {'poses', 'random_poses'} & typed.keys():
            changes = {'poses': None, 'pose': (), 'random_poses': None, **changes}
        elif 'pose' in typed:
            named = {parse_pose_option(text)[0] for text in typed['pose']}
            own = (one for one in self.robots.pose if parse_pose_option(one)[0] not in named)
            changes['pose'] = (*own, *typed['pose'])
        if typed.get('model'):
            changes.setdefault('limits', NO_LIMITS)
        return self.replace(**changes)

    def start_poses(self) -> Floats:
        """Return the start poses of a simulation: x, y in m and theta in rad, (3, nb_robots).

        Raises:
            SetcmasError: They are invalid, or the safety filter allows no robot there.
        """
        poses = self.robots.start_poses(self.nb_robots)
        check_starts(self.safety, poses)
        return poses

    def named(self, name: str) -> dict[str, list[int]]:
        """Return each text of a value, with its robots; no robots means all."""
        return robots_by_text(self.values()[name])

    def scripts(self) -> list[Path]:
        """Return the scripts that it names by paths, except shipped laws."""
        found = [Path(text) for name in (*_OF_FUNCTIONS, 'model') for text in self.named(name)]
        return [path for path in found if path.suffix == '.py' and not built_in_name(path)]

    def located(self, place: Callable[[str, str], str]) -> Scenario:
        """Return the same with the paths of the files that it names, or raise SetcmasError.

        `place` returns the path for the name and the text of a value.
        """
        values = self.values()
        found = {}
        for name in OF_FILES:
            text = str(values[name]) if isinstance(values[name], Path) else values[name]
            if isinstance(text, str):
                found[name] = _option(name).kind.located(text, partial(place, name))
        return self.replace(**found)

    def record(self) -> dict[str, Any]:
        """Return version and values as YAML has them; functions by name, None for no limit."""
        found = {k: v for _, part in self._parts() for k, v in part.record().items()}
        names = {name: name_of(self.values()[name]) for name in _OF_FUNCTIONS}
        return {'version': VERSION, **found, **names}

    def save(self, path: str | Path) -> Path:
        """Write the scenario, without defaults, to a file in the folder of its scripts and files.

        Returns its path. Raises SetcmasError for a function or a matrix, for a file in another
        folder, or if the file cannot be written.
        """
        target = Path(path)
        content = {
            name: _written(name, value, target.parent) for name, value in self.changed().items()
        }
        with file_errors(f"'{target}' cannot be written"):
            write_yaml({'version': VERSION, **content}, target)
        return target


_OF_FUNCTIONS = ('algo', 'si_to_uni', 'ctc')


def _check_version(version: Any) -> None:
    if version != VERSION:
        raise SetcmasError(
            f'version is {version!r}; it must be {VERSION}, the only one that this setcmas reads'
        )


def _found(name: Any, law: LawOptions) -> str:
    return LawScripts(str(name), law.exercise).text


def _absolute(text: str) -> str:
    return str(Path(text).absolute()) if Path(text).is_file() else text


def name_of(given: Algo | Condition | GivenConversion) -> str | None:
    """Return the name of scripts or functions in a record."""
    if isinstance(given, Mapping):
        return format_per_robot({robot: str(name_of(own)) for robot, own in given.items()})
    if callable(given):
        return str(getattr(given, '__name__', 'function'))
    return None if given is None else str(given)


@cache
def options() -> dict[str, Option]:
    """Return the options of scenarios by name."""
    return {
        name: option for part in Scenario.PARTS.values() for name, option in part.options().items()
    }


def _option(name: str) -> Option:
    known = options()
    if name not in known:
        expected = it_must_be(f'one of {", ".join(known)}', name, known)
        raise SetcmasError(f"a scenario has no value '{name}'{expected}")
    return known[name]


def _written(name: str, value: Any, folder: Path) -> Any:
    """Return a value for a file, or raise SetcmasError if no file can hold it."""
    is_several = name in _OF_FUNCTIONS and isinstance(value, Mapping)
    several = value.values() if is_several else [value]
    if any(map(callable, several)):
        raise SetcmasError(f'{name} is a function, which no file can hold; name a script')
    if name == 'graph' and not isinstance(value, str):
        raise SetcmasError('graph is a matrix; write it to a graph file and name that')
    text = str(value) if isinstance(value, Path) else value
    return plain(_option(name).kind.located(text, partial(named_in, folder, name)))
