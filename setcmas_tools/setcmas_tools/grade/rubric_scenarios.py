"""Scenarios of a rubric: each is run with a submission, and marked by criteria."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from setcmas_ctrl.scripts.loader import ALGORITHMS
from setcmas_simu.errors import SetcmasError
from setcmas_simu.yaml_entries import Entry
from setcmas_tools.grade.criteria import Criterion, read_criteria
from setcmas_tools.scenario.scenario import Scenario, options
from setcmas_tools.scenario.scenario_files import OF_FILES, ScenarioFolder

CONTROL, CTC = 'control', 'ctc'
"""Functions that a submission may define: a control law, or a triggering condition."""

_OWN = ('name', 'criteria', 'hidden', 'seeds')
_PLACES = {CONTROL: 'algo', CTC: 'ctc'}


@dataclass(frozen=True)
class MarkedScenario:
    """A scenario to run with a submission, and the criteria for its run.

    Attributes:
        name: Its name, unique in the rubric.
        criteria: Criteria for its run.
        base: The scenario without the submission.
        hidden: Whether students only see its points.
    """

    name: str
    criteria: tuple[Criterion, ...]
    base: Scenario
    hidden: bool = False

    def of(self, submission: Any, function: str = CONTROL) -> Scenario:
        """Return the scenario with a submission as its law or condition.

        Args:
            submission: A script, a function, or a function for each robot, {1: ..., 2: ...}.
            function: Which function the submission is, CONTROL or CTC.
        """
        return self.base.replace(**{_PLACES[function]: submission})

    @property
    def seconds(self) -> float:
        """Duration of its run in s."""
        return self.base.time.duration

    def shown(self) -> MarkedScenario:
        """Return the scenario without hidden criteria."""
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
        """The files that it names."""
        named = [Path(text) for name in OF_FILES for text in self.base.named(name)]
        return tuple(path for path in named if path.is_absolute())


def read_scenarios(entry: Entry, function: str) -> list[MarkedScenario]:
    """Return the scenario of an entry of a rubric, once for each of its seeds.

    Args:
        entry: The entry.
        function: The submissions' function.

    Raises:
        SetcmasError: The entry is invalid; the message has its line.
    """
    submitted = {'algo', 'exercise'} if function == CONTROL else {'ctc', 'event_triggered'}
    fields = entry.fields((*_OWN, *(name for name in options() if name not in submitted)))
    for name in ('name', 'criteria'):
        if name not in fields:
            raise entry.mistake(f'a scenario with a {name}, such as {_EXAMPLES[name]}')
    name = fields['name'].text()
    given = {key: one for key, one in fields.items() if key not in _OWN}
    base = Scenario.of('')
    if function == CTC:
        base = Scenario.of(str(ALGORITHMS.file('consensus')), event_triggered=True)
    base = Scenario.read(replace(entry, value=given), base)
    hidden = 'hidden' in fields and fields['hidden'].flag()
    criteria = read_criteria(fields['criteria'])
    if 'seeds' not in fields:
        return [_checked(entry, MarkedScenario(name, criteria, base, hidden))]
    seeds = [options()['seed'].read(one, str) for one in fields['seeds'].items()]
    if 'seed' in fields or not seeds:
        raise entry.error('seeds must be a non-empty list, without a separate seed')
    seeded = ((f'{name}, seed {seed}', base.replace(seed=seed)) for seed in seeds)
    return [_checked(entry, MarkedScenario(own, criteria, one, hidden)) for own, one in seeded]


_EXAMPLES = {'name': 'name: eight robots', 'criteria': 'criteria: [{metric: ..., at_most: ...}]'}


def _checked(entry: Entry, scenario: MarkedScenario) -> MarkedScenario:
    with entry.located():
        scenario.base.start_poses()
    return scenario


def read_solution(entry: Entry) -> Path:
    """Return the script of a solution: a file in the rubric's folder, or a built-in law.

    Raises:
        SetcmasError: It does not exist.
    """
    try:
        return Path(ScenarioFolder(entry.file.parent).place_of('algo')(entry.text()))
    except SetcmasError as error:
        raise entry.error(
            f"the solution of this rubric, '{entry.text()}', is missing: {error}. Students need "
            'a copy without it, which `setcmas grade --handout` writes'
        ) from None
