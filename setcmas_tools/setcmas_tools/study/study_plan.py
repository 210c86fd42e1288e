"""Plan of a study: common options, varied values, files, and checks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl.control.control_options import LawOptions
from setcmas_simu.errors import SetcmasError
from setcmas_tools.measures.metric import Metric
from setcmas_tools.offline.simulation import Simulation
from setcmas_tools.scenario.scenario import Scenario, name_of
from setcmas_tools.scenario.scenario_files import OF_FILES, ScenarioFolder
from setcmas_tools.study import variation
from setcmas_tools.study.study_cases import SEED, CaseTable, located_at, read_cases
from setcmas_tools.study.study_columns import COLUMNS, check_metrics, digest_of
from setcmas_tools.study.study_files import FILE_NAME, KeptFiles, StudyInfo, read_info
from setcmas_tools.study.study_row import kept
from setcmas_tools.study.success import check_columns

_RESERVED = {*COLUMNS, 'run', 'state', 'robots', 'message'}


def check_names(names: Sequence[str], seeds: int) -> None:
    """Check that varied names can be columns of one table.

    Raises:
        SetcmasError: They cannot.
    """
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise SetcmasError(f"'{min(twice)}' is varied twice; vary it once")
    if taken := _RESERVED.intersection(names):
        raise SetcmasError(
            f"the table already has a column '{min(taken)}'; rename the variable of the script"
        )
    if SEED in names and seeds > 1:
        raise SetcmasError(f'both --vary {SEED} and --seeds vary the seed; remove one')


def covering_runs(table: CaseTable) -> Iterator[int]:
    """Yield runs that together cover each value of each axis."""
    stride = 1
    for _, values in reversed(table.axes):
        yield from (1 + index * stride for index in range(len(values)))
        stride *= len(values)


def check_scenario(scenario: Scenario) -> None:
    """Check that a scenario can be simulated.

    Raises:
        SetcmasError: It cannot.
    """
    Simulation(scenario)
    scenario.check()


Variation = str | Sequence[Any] | Mapping[Any, Any]
"""Values of a name: text as on the command line, a sequence, or values by label."""


@dataclass(frozen=True)
class Plan:
    """A study before its runs.

    Attributes:
        info: What its folder records.
        base: The common scenario of all runs.
        files: Files named by its options.
        objects: Functions, which cannot be written, by option and label.
        metrics: Its own metrics by name.
    """

    info: StudyInfo
    base: Scenario
    cases: CaseTable
    files: KeptFiles
    objects: Mapping[str, Mapping[Any, Any]] = field(default_factory=dict)
    metrics: Mapping[str, Metric] = field(default_factory=dict)

    def scenario(self, run: int, folder: Path | None = None) -> Scenario:
        """Return the scenario of a run.

        Args:
            run: Its number.
            folder: Folder of the study, for the paths of its files; None keeps 'inputs/...'.

        Raises:
            SetcmasError: There is no such run, or a file is missing.
        """
        found = variation.with_values(self.base, self._filled_in(self.cases.values(run)))
        return found.located(ScenarioFolder(folder).place_of) if folder else found

    def original(self, run: int) -> Scenario:
        """Return the scenario of a run, with the original paths of its files."""
        return self.scenario(run).located(kept(lambda name: str(self.files.originals[name])))

    def _filled_in(self, varied: Mapping[str, Any]) -> dict[str, Any]:
        """Return varied values with labels replaced by files and functions."""
        values = self.base.values()
        found = dict(varied)
        for stand_ins in (self.files.texts, self.objects):
            for name, by_value in dict[str, Mapping[Any, Any]](stand_ins).items():
                key = name if name in found else f'{variation.OPTION}{name}'
                value = found.get(key, values.get(name))
                value = str(value) if isinstance(value, Path) else value
                if isinstance(value, (str, float, int)) and value in by_value:
                    found[key] = by_value[value]
        return found


def make_plan(
    base: Scenario,
    vary: Mapping[str, Variation],
    cases: Path | None = None,
    seeds: int = 1,
    success: str | None = None,
    metrics: Mapping[str, Metric] | None = None,
) -> Plan:
    """Return the plan of a study.

    Args:
        base: The common scenario of all runs.
        vary: Values to vary, by name.
        cases: A CSV file of names and values that vary together.
        seeds: Number of seeds.
        success: Condition for a successful run.
        metrics: Further metrics by name.

    Raises:
        SetcmasError: A name, value or file is unknown, or values contradict each other.
    """
    objects: dict[str, dict[Any, Any]] = {}
    for name, values in vary.items():
        if isinstance(values, Mapping):
            objects.setdefault(variation.plain(name), {}).update(values)
    names = _script_names(base.law, vary, objects)
    heads, rows = read_cases(cases) if cases else ([], {})
    with located_at(cases, 1):
        heads = [variation.checked_name(name, names) for name in heads]
    own = check_metrics(metrics or {})
    check_names([*(variation.checked_name(name, names) for name in vary), *heads, *own], seeds)
    varied = {variation.checked_name(name, names): values for name, values in vary.items()}
    known: dict[str, Any] = {}
    for name, values in varied.items():
        known[name] = _values(name, values, base.seed, objects)
    table = case_table(known, heads, rows, seeds, base.seed, cases)
    files = _kept_files(base, table, (cases, heads, list(rows)), objects)
    info = StudyInfo(
        base.record(), _recorded(known), heads, seeds, success, files.texts, files.digests,
        {name: digest_of(metric) for name, metric in own.items()},
    )  # fmt: skip
    plan = Plan(info, base, table, files, objects, own)
    if success:
        check_columns(success, [*known, *heads, SEED], own)
    for run in covering_runs(table):
        with located_at(cases, _line(run, table, list(rows))):
            check_scenario(plan.original(run))
    return plan


def _line(run: int, table: CaseTable, lines: Sequence[int]) -> int | None:
    """Return the line in the file of cases of a run that differs from run 1 only by its case."""
    index = (run - 1) % table.nb_cases * len(lines) // table.nb_cases
    return lines[index] if lines and (index or len(table.axes) == 1) else None


def case_table(
    vary: Mapping[str, Any], heads: Sequence[str], rows: Mapping[int, Sequence[Any]],
    seeds: int, seed: int, path: Path | None = None,
) -> CaseTable:  # fmt: skip
    """Return the cases of a study.

    Args:
        vary: Values, or a random distribution, for each name.
        heads: Names of the columns of the file of cases.
        rows: Its rows by line.
        seeds: Number of seeds.
        seed: First seed.
        path: The file of cases, for messages.

    Raises:
        SetcmasError: The file has an invalid value.
    """
    typed = []
    for line, row in rows.items():
        with located_at(path, line):
            typed.append(tuple(map(variation.value_of, heads, row)))
    axes = [(tuple(heads), typed)] if heads else []
    draws = {name: values for name, values in vary.items() if isinstance(values, variation.Draw)}
    axes += [
        ((name,), [(v,) for v in values]) for name, values in vary.items() if name not in draws
    ]
    return CaseTable(axes, draws, seed, seeds)


def _values(
    name: str, values: Variation, seed: int, objects: dict[str, dict[Any, Any]]
) -> list[Any] | variation.Draw:
    """Return the values of a name; functions stay among the objects, by label."""
    if isinstance(values, Mapping):
        return list(values)
    read = variation.parse_variation(name, values, seed) if isinstance(values, str) else values
    if isinstance(read, variation.Draw):
        return read
    found = []
    for value in map(_plain, read):
        if callable(value):
            stand_in = name_of(value)
            objects.setdefault(variation.plain(name), {})[stand_in] = value
            value = stand_in
        elif value not in objects.get(variation.plain(name), ()):
            value = variation.value_of(name, value)
        found.append(value)
    return found


def _plain(value: Any) -> Any:
    """Return a value as in YAML, unless it is a function."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (tuple, list)):
        return [_plain(one) for one in value]
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    return str(value) if isinstance(value, Path) else value


def _recorded(vary: Mapping[str, Any]) -> dict[str, Any]:
    return {name: str(v) if isinstance(v, variation.Draw) else v for name, v in vary.items()}


def _script_names(
    law: LawOptions, vary: Mapping[str, Variation], objects: Mapping[str, Any]
) -> set[str]:
    """Return the variables that the control scripts assign."""
    laws = vary.get('algo', [law.algo])
    read: Any = variation.parse_variation('algo', laws, 0) if isinstance(laws, str) else laws
    texts = [one for one in read if isinstance(one, str) and one not in objects.get('algo', ())]
    return {name for text in texts for name in variation.names_of_scripts(text, law.exercise)}


def _kept_files(
    base: Scenario, table: CaseTable, given: tuple[Path | None, Sequence[str], Sequence[int]],
    objects: Mapping[str, Mapping[Any, Any]],
) -> KeptFiles:  # fmt: skip
    files, own = KeptFiles(), base.values()
    cases, heads, lines = given
    varied: dict[str, list[Any]] = {}
    for names, rows in table.axes:
        for name, *values in zip(names, *rows, strict=True):
            if not variation.is_setting(name):
                varied[variation.plain(name)] = values
    for option in OF_FILES:
        of_case = option in map(variation.plain, heads)
        for index, value in enumerate(varied.get(option, [own[option]])):
            value = str(value) if isinstance(value, Path) else value
            if isinstance(value, str) and value not in objects.get(option, ()):
                with located_at(cases, lines[index] if of_case else None):
                    files.add(option, value, base.law.exercise)
    if cases:
        files.add('cases', str(cases))
    return files


def read_plan(folder: Path) -> Plan:
    """Read the plan of the study in a folder.

    Raises:
        SetcmasError: There is no study, or a file is damaged.
    """
    info = read_info(folder)
    if info is None:
        raise SetcmasError(f"'{folder}' has no {FILE_NAME}; it must be the folder of a study")
    rows: Mapping[int, Sequence[str]] = {}
    if info.cases:
        _, rows = read_cases(folder / next(iter(info.files['cases'].values())))
    base = Scenario.recorded(info.scenario)
    vary = {
        name: values
        if isinstance(values, list)
        else variation.parse_variation(name, values, base.seed)
        for name, values in info.vary.items()
    }
    table = case_table(vary, info.cases, rows, info.seeds, base.seed)
    return Plan(info, base, table, KeptFiles(info.files))
