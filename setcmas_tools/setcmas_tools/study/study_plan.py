"""Plan of a study: its common scenario, the values of each run, and checks before it starts."""

from __future__ import annotations

import csv
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_simu.options import plain as plain_value
from setcmas_tools.measures.metric import Metric
from setcmas_tools.offline.loaded_scenario import Simulation
from setcmas_tools.scenario.scenario import Scenario, name_of
from setcmas_tools.scenario.scenario_files import ScenarioFolder
from setcmas_tools.study import variation
from setcmas_tools.study.study_columns import COLUMNS, OUTCOME, check_metrics, digest_of
from setcmas_tools.study.study_files import FILE_NAME, KeptFiles, StudyInfo, read_info

SEED = 'seed'
_RESERVED = {*COLUMNS, *OUTCOME, 'run'}

Variation = str | Sequence[Any] | Mapping[str, Any]
"""Values of a name: text as on the command line, a sequence, or values by label."""


@dataclass(frozen=True)
class Plan:
    """A study before its runs.

    Attributes:
        info: What its folder records.
        base: The common scenario of all runs.
        objects: Functions and matrices, which cannot be written, by name and label.
        metrics: Its own metrics by name.
        contents: Contents of its files, by path in its folder.
    """

    info: StudyInfo
    base: Scenario
    objects: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    metrics: Mapping[str, Metric] = field(default_factory=dict)
    contents: Mapping[str, bytes] = field(default_factory=dict)

    @cached_property
    def runs(self) -> list[dict[str, Any]]:
        """Values of each run by name, its seed last.

        The last name varies fastest. Seeds vary slowest, so more of them add runs at the end.
        """
        seeds = [{SEED: self.base.seed + k} for k in range(self.info.seeds)]
        if any(SEED in axis[0] for axis in self.axes):
            seeds = [{}]
        return [_merged([*parts, seed]) for seed, *parts in product(seeds, *self.axes)]

    @property
    def axes(self) -> list[list[dict[str, Any]]]:
        """Values that vary together, by name, for each of the axes that are combined."""
        cases = [self.info.cases] if self.info.cases else []
        return [*cases, *([{name: v} for v in vs] for name, vs in self.info.vary.items())]

    @property
    def names(self) -> list[str]:
        """Varied names, without the seed."""
        return [name for axis in self.axes for name in axis[0] if name != SEED]

    def scenario(self, run: int) -> Scenario:
        """Return the scenario of a run, numbered from 1; raise SetcmasError if it is unknown."""
        if not 1 <= run <= len(self.runs):
            raise SetcmasError(f'unknown run {run}; must be from 1 to {len(self.runs)}')
        return self.scenario_with(self.runs[run - 1])

    def scenario_with(self, values: Mapping[str, Any]) -> Scenario:
        """Return the scenario of a run with some values."""
        found = {
            name: self.objects.get(name, {}).get(value, value) if isinstance(value, str) else value
            for name, value in values.items()
        }
        return variation.with_values(self.base, found)

    def kept_scenario(self, run: int) -> Scenario:
        """Return the same with the copies of its files, as 'inputs/...'."""
        found = self.scenario(run)
        values = found.values()
        kept = {name: texts.get(str(values[name])) for name, texts in self.info.files.items()}
        return found.replace(**{name: text for name, text in kept.items() if text})


def _merged(parts: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    return {name: value for part in parts for name, value in part.items()}


def located_in(folder: Path, kept: Scenario) -> Scenario:
    """Return a scenario with the files of a study's folder; raise SetcmasError if not there."""
    return kept.located(ScenarioFolder(folder).place_of)


def make_plan(
    base: Scenario,
    vary: Mapping[str, Variation],
    cases: Path | None = None,
    seeds: int = 1,
    metrics: Mapping[str, Metric] | None = None,
) -> Plan:
    """Return the plan of a study, with arguments as for `sweep`, or raise SetcmasError."""
    labelled = {name: _labelled(name, values) for name, values in vary.items()}
    laws, functions = labelled.get('algo', ([base.law.algo], {}))
    texts = [law for law in laws if isinstance(law, str) and law not in functions]
    known = set().union(*(variation.names_of_scripts(text, base.law.exercise) for text in texts))
    names = [variation.checked_name(name, known) for name in vary]
    rows, own = read_cases(cases, known) if cases else {}, check_metrics(metrics or {})
    check_names([*names, *next(iter(rows.values()), ()), *own], seeds)
    pairs = list(zip(names, labelled.values(), strict=True))
    objects = {name: found for name, (_, found) in pairs}
    values = {name: _values(name, labels, found) for name, (labels, found) in pairs}
    info = StudyInfo(base.record(), list(rows.values()), values, seeds)
    plan, files = Plan(info, base, objects, own), KeptFiles()
    for line, changed in _covering(plan.axes, list(rows)):
        with located_at(cases, line):
            scenario = plan.scenario_with(changed)
            Simulation(scenario)
            scenario.check()
            files.add(scenario)
    sources = {name: digest_of(metric) for name, metric in own.items()}
    info = replace(info, files=files.texts, metrics=sources)
    return replace(plan, info=info, contents=files.contents)


def check_names(names: Sequence[str], seeds: int) -> None:
    """Raise SetcmasError unless varied names can be columns of one table."""
    if twice := {name for name in names if names.count(name) > 1}:
        raise SetcmasError(f"'{min(twice)}' is varied twice; vary it once")
    if taken := _RESERVED.intersection(names):
        raise SetcmasError(
            f"the table already has a column '{min(taken)}'; rename the variable of the script"
        )
    if SEED in names and seeds > 1:
        raise SetcmasError(f'both --vary {SEED} and --seeds vary the seed; remove one')


def _covering(
    axes: Sequence[Sequence[Mapping[str, Any]]], lines: Sequence[int]
) -> Iterator[tuple[int | None, dict[str, Any]]]:
    """Yield values of runs that together have each value of each axis.

    And the line in the file of cases, if a run differs from the first only by its case.
    """
    first = _merged(axis[0] for axis in axes)
    yield lines[0] if lines and len(axes) == 1 else None, first
    for axis in axes:
        for index, values in enumerate(axis[1:], 1):
            yield lines[index] if lines and axis is axes[0] else None, {**first, **values}


def _labelled(name: str, values: Variation) -> tuple[list[Any], dict[str, Any]]:
    """Return the values of a name as the table shows them, and objects by the labels of these."""
    if isinstance(values, Mapping):
        return list(values), dict(values)
    if isinstance(values, str):
        return variation.parse_values(name, values), {}
    objects = {str(name_of(value)): value for value in values if callable(value)}
    return [name_of(one) if callable(one) else plain_value(one) for one in values], objects


def _values(name: str, labels: Sequence[Any], objects: Mapping[str, Any]) -> list[Any]:
    return [
        label if isinstance(label, str) and label in objects else variation.value_of(name, label)
        for label in labels
    ]


def read_plan(folder: Path) -> Plan:
    """Read the plan of the study in a folder; raise SetcmasError without one."""
    info = read_info(folder)
    if info is None:
        raise SetcmasError(f"'{folder}' has no {FILE_NAME}; it must be the folder of a study")
    return Plan(info, Scenario.recorded(info.scenario))


def read_cases(path: Path, script_names: Collection[str]) -> dict[int, dict[str, Any]]:
    """Read a CSV file of cases: by line, their values by name, or raise SetcmasError."""
    rows: dict[int, list[str]] = {}
    try:
        with path.open(encoding='utf-8-sig', newline='') as file:
            reader = csv.reader(file)
            for row in filter(None, reader):
                rows[reader.line_num] = [cell.strip() for cell in row]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = getattr(error, 'strerror', None) or str(error)
        raise SetcmasError(f"cases '{path}' cannot be read: {reason}") from error
    if len(rows) < 2:
        raise SetcmasError(f"cases '{path}' must have a line of names, then a line per case")
    line = min(rows)
    with located_at(path, line):
        heads = [variation.checked_name(name, script_names) for name in rows.pop(line)]
        check_names(heads, seeds=1)
    cases = {}
    for line, row in rows.items():
        if len(row) != len(heads):
            raise SetcmasError(
                f"cases '{path}', line {line} has {len(row)} cells; it must have "
                f'{len(heads)}, as the first line'
            )
        with located_at(path, line):
            cases[line] = {
                name: variation.value_of(name, cell) for name, cell in zip(heads, row, strict=True)
            }
    return cases


@contextmanager
def located_at(path: Path | None, line: int | None) -> Iterator[None]:
    """Add file and line of a case to errors; without a line, change nothing."""
    try:
        yield
    except SetcmasError as error:
        if line is None:
            raise
        text = str(error).removeprefix('--vary ')
        raise SetcmasError(f"cases '{path}', line {line}: {text}") from error
