"""Plan of a study: its common scenario, the values of each run, and its study.yaml and inputs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_tools.measures.metric import METRICS, Metric
from setcmas_tools.offline.offline_simulation import Simulation
from setcmas_tools.run.run_folder import RunInput, inputs_of, kept_record, remove_parts
from setcmas_tools.run.run_info import INFO_FILE as RUN_FILE
from setcmas_tools.run.run_info import Origin, read_record, this_origin, write_record
from setcmas_tools.run.scenario import Scenario
from setcmas_tools.run.scenario_files import INPUTS, OF_FILES, ScenarioFolder
from setcmas_tools.study.study_columns import COLUMNS, OUTCOME
from setcmas_tools.study.variation import (
    Variation,
    checked_name,
    names_of_scripts,
    values_by_label,
    with_values,
)

FILE_NAME = 'study.yaml'
TABLE = 'runs.csv'
SEED = 'seed'

_PARTS = (INPUTS, TABLE, 'plots', FILE_NAME)
_RESERVED = {*COLUMNS, *OUTCOME, 'run', SEED}


@dataclass(frozen=True)
class StudyInfo:
    """Content of study.yaml.

    Attributes:
        scenario: The common scenario of its runs, as from `Scenario.record`.
        vary: Values by their labels in the table, for each varied name.
        seeds: Number of seeds; the first one is the scenario's.
        origin: Versions that made it.
    """

    scenario: dict[str, Any]
    vary: dict[str, dict[str, Any]]
    seeds: int
    origin: Origin


@dataclass(frozen=True)
class Plan:
    """A study before its runs.

    Attributes:
        base: The common scenario of all runs.
        vary: Values by their labels in the table, for each varied name.
        seeds: Number of seeds; the first one is that of the scenario.
        metrics: Its own metrics by name.
        folder: The folder with the files of its scenarios; None if these have absolute paths.
    """

    base: Scenario
    vary: Mapping[str, Mapping[str, Any]]
    seeds: int = 1
    metrics: Mapping[str, Metric] = field(default_factory=dict)
    folder: Path | None = None

    @cached_property
    def runs(self) -> list[dict[str, Any]]:
        """Labels of each run by name, and its seed. The last name varies fastest, seeds last."""
        return [
            {**dict(zip(self.vary, labels, strict=True)), SEED: self.base.seed + k}
            for k in range(self.seeds)
            for labels in product(*self.vary.values())
        ]

    def scenario(self, run: int) -> Scenario:
        """Return the scenario of a run, numbered from 1; raise SetcmasError if it is unknown."""
        if not 1 <= run <= len(self.runs):
            raise SetcmasError(f'unknown run {run}; must be from 1 to {len(self.runs)}')
        labels = dict(self.runs[run - 1])
        seed = labels.pop(SEED)
        found = self.scenario_of(labels).replace(seed=seed)
        return found.located(ScenarioFolder(self.folder).place) if self.folder else found

    def scenario_of(self, labels: Mapping[str, str]) -> Scenario:
        """Return the scenario with values by their labels; raise SetcmasError if they clash."""
        return with_values(self.base, {n: self.vary[n][label] for n, label in labels.items()})


def make_plan(
    base: Scenario,
    vary: Iterable[tuple[str, Variation]],
    seeds: int = 1,
    metrics: Mapping[str, Metric] | None = None,
) -> Plan:
    """Return the plan of a study, with arguments as for `sweep`, or raise SetcmasError."""
    pairs = [*vary]
    laws = [base.law.algo]
    if 'algo' in dict(pairs):
        laws = [*values_by_label('algo', dict(pairs)['algo']).values()]
    texts = [law for law in laws if isinstance(law, str)]
    script_names = set().union(*(names_of_scripts(text, base.law.exercise) for text in texts))
    varied: dict[str, dict[str, Any]] = {}
    for given, values in pairs:
        name = checked_name(given, script_names)
        if name in varied:
            raise SetcmasError(f"'{name}' is varied twice; vary it once")
        if name in _RESERVED:
            raise SetcmasError(
                f"the table already has a column '{name}'; rename the variable of the script"
            )
        varied[name] = values_by_label(name, values)
    for name in metrics or {}:
        if name in METRICS or name in COLUMNS:
            raise SetcmasError(f"metric '{name}' exists already; choose another name")
    plan = Plan(base, varied, seeds, dict(metrics or {}))
    for labels in _covering(plan.vary):
        scenario = plan.scenario_of(labels)
        Simulation(scenario)
        scenario.check()
    return plan


def _covering(vary: Mapping[str, Mapping[str, Any]]) -> Iterator[dict[str, str]]:
    """Yield labels by name of runs that together have each value of each name."""
    first = {name: next(iter(values)) for name, values in vary.items()}
    yield first
    for name, values in vary.items():
        for label in [*values][1:]:
            yield {**first, name: label}


def read_plan(folder: Path) -> Plan:
    """Read the plan of the study in a folder; raise SetcmasError without one."""
    info = read_record(folder / FILE_NAME, StudyInfo)
    if info is None:
        raise SetcmasError(f"'{folder}' has no {FILE_NAME}; it must be the folder of a study")
    return Plan(Scenario.recorded(info.scenario), info.vary, info.seeds, folder=folder)


def store(plan: Plan, folder: Path, overwrite: bool = False) -> None:
    """Write study.yaml and the scripts and files of a study to its folder.

    Raises SetcmasError if the folder holds anything but an earlier study to `overwrite`.
    """
    _check_free(folder, overwrite)
    records: list[dict[str, Any]] = []
    kept = {name: dict(values) for name, values in plan.vary.items()}
    contents: dict[str, bytes] = {}
    for labels in _covering(plan.vary):
        found = plan.scenario_of(labels).found()
        inputs = inputs_of(found)
        records.append(kept_record(found, inputs))
        for name in OF_FILES:
            if name in kept and isinstance(text := records[-1][name], str):
                kept[name][labels[name]] = text
        for one in inputs:
            _add(contents, one)
    remove_parts(folder, _PARTS)
    for name, content in contents.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    folder.mkdir(parents=True, exist_ok=True)
    write_record(StudyInfo(records[0], kept, plan.seeds, this_origin()), folder / FILE_NAME)


def _check_free(folder: Path, overwrite: bool) -> None:
    if folder.exists() and not folder.is_dir():
        raise SetcmasError(f"output '{folder}' is not a folder")
    taken = [part for part in (*_PARTS, RUN_FILE) if (folder / part).exists()]
    if taken and FILE_NAME not in taken:
        raise SetcmasError(
            f"output '{folder}' holds {', '.join(taken)} but no {FILE_NAME}, so it is "
            'not a study; choose another folder'
        )
    if taken and not overwrite:
        raise SetcmasError(
            f"output '{folder}' holds an earlier study; choose another folder, or add --overwrite"
        )


def _add(contents: dict[str, bytes], given: RunInput) -> None:
    """Add the files of an input by their paths in the folder of a study."""
    for file, content in zip(given.files, given.contents, strict=True):
        path = f'{given.folder}/{file.relative_to(given.path.parent).as_posix()}'
        if contents.setdefault(path, content) != content:
            raise SetcmasError(
                f"'{file}' and another file would both be stored as '{path}'; rename one"
            )
