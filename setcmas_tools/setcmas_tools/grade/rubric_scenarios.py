"""Scenario of a rubric: a run that is made with a submission, and the criteria of its marks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from setcmas_ctrl.scripts.loader import ALGORITHMS
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import start_poses
from setcmas_simu.fleet.per_robot import mapped
from setcmas_simu.fleet.start_poses import load_poses, poses_of_entry
from setcmas_simu.options.option import Form
from setcmas_simu.yaml_entries import Entry
from setcmas_tools.grade.criteria import Criterion, read_criteria
from setcmas_tools.run.run_folder import RunOptions
from setcmas_tools.study.study_row import OF_FILES, simulation_of
from setcmas_tools.study.variation import OPTIONS

CONTROL, CTC = 'control', 'ctc'
"""Functions that a submission may define: a control law, or a triggering condition."""

_FILES = (*OF_FILES, 'obstacles')
_OWN = ('name', 'criteria', 'hidden', 'seeds', 'set')
_PLACES = {CONTROL: 'algo', CTC: 'ctc'}


@dataclass(frozen=True)
class Scenario:
    """A run that is made with a submission.

    Attributes:
        name: What it is called, unique in its rubric.
        criteria: What its run is marked by.
        arguments: Those of `simulate` without the submission, `warn` and `progress`; start poses
            that are given or drawn are an array in 'poses'. Plain values, arrays and paths: they
            can be pickled.
        hidden: Whether students see nothing of it but its points.
    """

    name: str
    criteria: tuple[Criterion, ...]
    arguments: Mapping[str, Any]
    hidden: bool = False

    def job(self, submission: Any, function: str = CONTROL) -> dict[str, Any]:
        """Return the arguments of `simulate` with a submission in its place.

        Args:
            submission: What `simulate` takes as `algo` or `ctc`: a script, a function, or (laws
                only) a function for each robot, {1: ..., 2: ...}.
            function: Which function the submission is, CONTROL or CTC.
        """
        return {**self.arguments, _PLACES[function]: submission}

    @property
    def seconds(self) -> float:
        """How long its run lasts, in s of its own time."""
        return float(self.arguments.get('duration', RunOptions.duration))

    def shown(self) -> Scenario:
        """Return the same without criteria that are hidden."""
        criteria = [one for one in self.criteria if not one.hidden]
        names = {one.name for one in criteria}
        return replace(
            self,
            criteria=tuple(
                one if one.needs in names else replace(one, needs='') for one in criteria
            ),
        )

    @property
    def files(self) -> tuple[Path, ...]:
        """The files that the arguments name."""
        found: list[Path] = []

        def note(text: str) -> str:
            found.extend([Path(text)] if Path(text).is_absolute() else [])
            return text

        for name in _FILES:
            if isinstance(value := self.arguments.get(name), str):
                mapped(value, note, name)
        return tuple(found)


def read_scenarios(entry: Entry, function: str) -> list[Scenario]:
    """Return the scenario that an entry of a rubric tells, once for each of its seeds.

    Args:
        entry: The entry.
        function: Which function submissions define.

    Raises:
        SetcmasError: It has a mistake; the message has its line.
    """
    others = {'algo', 'poses'} if function == CONTROL else {'ctc', 'poses', 'event_triggered'}
    taken = [name for name in OPTIONS if name not in others]
    fields = entry.fields((*_OWN, 'poses', *taken))
    for name in ('name', 'criteria'):
        if name not in fields:
            raise entry.mistake(f'a scenario with a {name}, such as {_EXAMPLES[name]}')
    name = fields['name'].text()
    arguments = {key: _value(one, key) for key, one in fields.items() if key in taken}
    if 'set' in fields:
        arguments['settings'] = _settings(fields['set'])
    if 'seeds' not in fields:
        return [_scenario(entry, fields, name, function, arguments)]
    seeds = [_value(one, 'seed') for one in fields['seeds'].items()]
    if 'seed' in fields or not seeds:
        raise entry.error('a scenario with seeds must have one at least, and no seed beside them')
    return [
        _scenario(entry, fields, f'{name}, seed {seed}', function, {**arguments, 'seed': seed})
        for seed in seeds
    ]


def _scenario(
    entry: Entry, fields: Mapping[str, Entry], name: str, function: str, arguments: dict[str, Any]
) -> Scenario:
    if function == CTC:
        arguments = {'algo': _located('consensus', entry), **arguments, 'event_triggered': True}
    try:
        checked = simulation_of({'algo': '', **arguments})
    except SetcmasError as error:
        raise entry.error(str(error)) from None
    if 'random_poses' in fields:
        del arguments['random_poses']
        arguments['poses'] = checked.start
    if 'poses' in fields:
        poses = arguments.setdefault('poses', start_poses(checked.nb_robots))
        for robot, pose in _poses(fields['poses'], checked.nb_robots).items():
            poses[:, robot - 1] = pose
    return Scenario(
        name=name,
        criteria=read_criteria(fields['criteria']),
        arguments=arguments,
        hidden='hidden' in fields and fields['hidden'].flag(),
    )


_EXAMPLES = {'name': 'name: eight robots', 'criteria': 'criteria: [{metric: ..., at_most: ...}]'}


def _value(entry: Entry, name: str) -> Any:
    """Return the value of an option of a run, checked as on the command line."""
    option = OPTIONS[name]
    if option.form is Form.FLAG:
        return entry.flag()
    value = _plain(entry)
    if name in _FILES and isinstance(value, str):
        value = mapped(value, lambda text: _located(text, entry, laws=name == 'algo'), name)
    if isinstance(value, str):
        value = option.kind.parse(value)
    try:
        option.kind.check(entry.name, value)
    except SetcmasError as error:
        raise entry.error(str(error)) from None
    return value


def _located(text: str, entry: Entry, laws: bool = True) -> str:
    """Return the path of a file beside the rubric or of a law that ships, or a name as it is."""
    if (entry.file.parent / text).is_file():
        return str((entry.file.parent / text).resolve())
    if not laws:
        return text
    try:  # never a file of the current folder, which may be a student's
        return str(ALGORITHMS.file(text))
    except SetcmasError as error:
        raise entry.error(str(error)) from None


def _settings(entry: Entry) -> dict[str, Any]:
    """Return values for names of the law."""
    if not isinstance(entry.value, dict):
        raise entry.mistake('a mapping from names of the law to values, such as {K: 1.2}')
    return {name: _plain(value) for name, value in entry.value.items()}


def _plain(entry: Entry) -> Any:
    if isinstance(entry.value, dict):
        return {key: _plain(value) for key, value in entry.value.items()}
    if isinstance(entry.value, list):
        return [_plain(item) for item in entry.value]
    return entry.value


def _poses(entry: Entry, nb_robots: int) -> Mapping[int, tuple[float, float, float]]:
    if not isinstance(entry.value, str):
        poses = poses_of_entry(entry, nb_robots)
    else:
        poses = load_poses(entry.file.parent / entry.value, nb_robots)
    if max(poses) > nb_robots:
        raise entry.error(
            f'{entry.name} has robot {max(poses)}; the fleet has robots 1 to {nb_robots}'
        )
    return poses


def read_solution(entry: Entry) -> Path:
    """Return the script of a solution: a file beside the rubric, or a law that ships.

    Raises:
        SetcmasError: There is none.
    """
    return Path(_located(entry.text(), entry))
