"""Plan of a study: common options, variation, the files that they name, and its checks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl.communication.communication_options import CommunicationOptions
from setcmas_ctrl.communication.communication_settings import check_communication
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_simu.errors import SetcmasError
from setcmas_tools.offline.given import name_of
from setcmas_tools.run.inputs import INPUTS
from setcmas_tools.run.run_info import RunInfo
from setcmas_tools.study.case_table import SEED, CaseTable, read_cases, told_at
from setcmas_tools.study.study_columns import COLUMNS
from setcmas_tools.study.study_files import FILE_NAME, KeptFiles, StudyInfo, read_info
from setcmas_tools.study.study_row import OF_FILES, arguments_of, located, simulation_of
from setcmas_tools.study.success import check_columns
from setcmas_tools.study.variation import (
    Draw,
    checked_name,
    is_setting,
    names_of_scripts,
    parse_variation,
    plain,
    value_of,
    with_values,
)

_RESERVED = {*COLUMNS, 'run', 'state', 'robots', 'message'}


def check_names(names: Sequence[str], seeds: int) -> None:
    """See that names that are varied can be columns of one table.

    Raises:
        SetcmasError: They cannot.
    """
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise SetcmasError(f"'{min(twice)}' is varied twice; it must be varied once")
    if taken := _RESERVED.intersection(names):
        raise SetcmasError(
            f"the table has a column '{min(taken)}' already; rename that name of the script"
        )
    if SEED in names and seeds > 1:
        raise SetcmasError(f'seeds are varied by --vary {SEED} and --seeds; leave one out')


def telling_runs(table: CaseTable) -> Iterator[int]:
    """Yield runs that together have each value of each axis."""
    stride = table.seeds
    for _, values in reversed(table.axes):
        yield from (1 + index * stride for index in range(len(values)))
        stride *= len(values)


def check_parameters(parameters: Mapping[str, Any]) -> None:
    """See that a run can be made.

    Raises:
        SetcmasError: It cannot.
    """
    simulation_of(arguments_of(parameters, print))
    check_communication(CommunicationOptions.among(parameters), parameters['nb_robots'])
    if isinstance(parameters['algo'], str):
        scripts = LawScripts(parameters['algo'], settings=parameters['set'])
        scripts.check(parameters['nb_robots'])
    elif parameters['set']:
        raise SetcmasError('settings are for scripts; a function takes none')


Variation = str | Sequence[Any] | Mapping[Any, Any]
"""Values of a name: as on the command line, a sequence, or what is meant by what it is called."""


@dataclass(frozen=True)
class Plan:
    """What a study is, ready to be made.

    Attributes:
        info: What its folder records.
        cases: Its runs.
        files: The files that its options name.
        objects: What cannot be written, by option and by what stands for it: functions.
    """

    info: StudyInfo
    cases: CaseTable
    files: KeptFiles
    objects: Mapping[str, Mapping[Any, Any]] = field(default_factory=dict)

    def parameters(self, run: int, place: Callable[[str], str] | None = None) -> dict[str, Any]:
        """Return the options of a run by name, settings of the script under 'set'.

        Args:
            run: Its number.
            place: Returns the path of a file that is kept as 'inputs/...'; None keeps these.

        Raises:
            SetcmasError: There is no such run.
        """
        found = with_values(self.info.parameters, self.cases.values(run))
        for stand_ins in (self.files.texts, self.objects):
            for option, by_value in dict[str, Mapping[Any, Any]](stand_ins).items():
                value = found.get(option)
                if isinstance(value, (str, float, int)) and value in by_value:
                    found[option] = by_value[value]
        return located(found, place) if place else found

    def run_info(self, run: int) -> RunInfo:
        """Return what a run is, as the run.yaml of its own would say.

        Raises:
            SetcmasError: There is no such run.
        """
        found = self.parameters(run)
        kept = {name: found[name] for name in OF_FILES if f'{INPUTS}/' in str(found[name])}
        return RunInfo(parameters=found, seed=found[SEED], inputs=kept)

    def original(self, name: str) -> str:
        """Return the path of a file that is kept as 'inputs/...', where it was found."""
        return str(self.files.originals[name])


def make_plan(
    parameters: Mapping[str, Any],
    vary: Mapping[str, Variation],
    cases: Path | None = None,
    seeds: int = 1,
    success: str | None = None,
) -> Plan:
    """Return the plan of a study.

    Args:
        parameters: Options of all runs by name, settings of the script under 'set'; 'exercise'
            says whether `algo` may name one.
        vary: What is varied, by name.
        cases: A CSV file of names and values that vary together.
        seeds: Number of seeds.
        success: What makes a run a success.

    Raises:
        SetcmasError: A name, a value or a file is not known, or values do not go together.
    """
    base = {name: _plain(value) for name, value in parameters.items() if name != 'exercise'}
    exercise = bool(parameters.get('exercise'))
    objects: dict[str, dict[Any, Any]] = {}
    for name in ('algo', 'ctc'):
        if callable(base[name]) or isinstance(base[name], Mapping):
            stand_in = name_of(base[name])
            objects[name], base[name] = {stand_in: base[name]}, stand_in
    for name, values in vary.items():
        if isinstance(values, Mapping):
            objects.setdefault(plain(name), {}).update(values)
    names = _script_names(base['algo'], vary, exercise, objects)
    heads, rows = read_cases(cases) if cases else ([], {})
    with told_at(cases, 1):
        heads = [checked_name(name, names) for name in heads]
    check_names([*(checked_name(name, names) for name in vary), *heads], seeds)
    varied = {checked_name(name, names): values for name, values in vary.items()}
    known: dict[str, Any] = {}
    for name, values in varied.items():
        known[name] = _values(name, values, base[SEED], objects)
    table = case_table(known, heads, rows, seeds, base[SEED], cases)
    files = _kept_files(base, table, (cases, heads, list(rows)), exercise, objects)
    info = StudyInfo(base, _recorded(known), heads, seeds, success, files.texts, files.digests)
    plan = Plan(info, table, files, objects)
    if success:
        check_columns(success, [*known, *heads, SEED])
    for run in telling_runs(table):
        with told_at(cases, _line(run, table, list(rows))):
            check_parameters(plan.parameters(run, plan.original))
    return plan


def _line(run: int, table: CaseTable, lines: Sequence[int]) -> int | None:
    """Return the line of a file of cases that a run is of, if nothing else tells it from run 1."""
    index = (run - 1) * len(lines) // len(table)
    return lines[index] if lines and (index or len(table.axes) == 1) else None


def case_table(
    vary: Mapping[str, Any], heads: Sequence[str], rows: Mapping[int, Sequence[Any]],
    seeds: int, seed: int, path: Path | None = None,
) -> CaseTable:  # fmt: skip
    """Return the cases of a study.

    Args:
        vary: A list of values, or a draw, for each name.
        heads: Names of the columns of a file of cases.
        rows: Its rows by line.
        seeds: Number of seeds.
        seed: The first one.
        path: The file of cases, for messages.

    Raises:
        SetcmasError: A value of the file is none of its name's.
    """
    typed = []
    for line, row in rows.items():
        with told_at(path, line):
            typed.append(tuple(map(value_of, heads, row)))
    axes = [(tuple(heads), typed)] if heads else []
    draws = {name: values for name, values in vary.items() if isinstance(values, Draw)}
    axes += [
        ((name,), [(v,) for v in values]) for name, values in vary.items() if name not in draws
    ]
    return CaseTable(axes, draws, seed, seeds)


def _values(
    name: str, values: Variation, seed: int, objects: dict[str, dict[Any, Any]]
) -> list[Any] | Draw:
    """Return the values of a name; functions stay with the objects, under what they are called."""
    if isinstance(values, Mapping):
        return list(values)
    read = parse_variation(name, values, seed) if isinstance(values, str) else values
    if isinstance(read, Draw):
        return read
    found = []
    for value in map(_plain, read):
        if callable(value):
            stand_in = name_of(value)
            objects.setdefault(plain(name), {})[stand_in] = value
            value = stand_in
        elif value not in objects.get(plain(name), ()):
            value = value_of(name, value)
        found.append(value)
    return found


def _plain(value: Any) -> Any:
    """Return a value as YAML has it, if it is no function."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (tuple, list)):
        return [_plain(one) for one in value]
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    return str(value) if isinstance(value, Path) else value


def _recorded(vary: Mapping[str, Any]) -> dict[str, Any]:
    return {name: str(v) if isinstance(v, Draw) else v for name, v in vary.items()}


def _script_names(
    algo: Any, vary: Mapping[str, Variation], exercise: bool, objects: Mapping[str, Any]
) -> set[str]:
    """Return what the control scripts assign."""
    laws = vary.get('algo', [algo])
    read: Any = parse_variation('algo', laws, 0) if isinstance(laws, str) else laws
    texts = [law for law in read if isinstance(law, str) and law not in objects.get('algo', ())]
    return {name for law in texts for name in names_of_scripts(law, exercise)}


def _kept_files(
    base: Mapping[str, Any], table: CaseTable,
    given: tuple[Path | None, Sequence[str], Sequence[int]], exercise: bool,
    objects: Mapping[str, Mapping[Any, Any]],
) -> KeptFiles:  # fmt: skip
    files = KeptFiles()
    cases, heads, lines = given
    varied: dict[str, list[Any]] = {}
    for names, rows in table.axes:
        for name, *values in zip(names, *rows, strict=True):
            if not is_setting(name):
                varied[plain(name)] = values
    for option in OF_FILES:
        of_case = option in map(plain, heads)
        for index, value in enumerate(varied.get(option, [base.get(option)])):
            if isinstance(value, str) and value not in objects.get(option, ()):
                with told_at(cases, lines[index] if of_case else None):
                    files.add(option, value, exercise)
    if cases:
        files.add('cases', str(cases))
    return files


def read_plan(folder: Path) -> Plan:
    """Return the plan of the study in a folder.

    Raises:
        SetcmasError: There is no study, or a file is damaged.
    """
    info = read_info(folder)
    if info is None:
        raise SetcmasError(f"there is no {FILE_NAME} in '{folder}'; it must be a study's folder")
    rows: Mapping[int, Sequence[str]] = {}
    if info.cases:
        _, rows = read_cases(folder / next(iter(info.files['cases'].values())))
    seed = info.parameters[SEED]
    vary = {
        name: values if isinstance(values, list) else parse_variation(name, values, seed)
        for name, values in info.vary.items()
    }
    table = case_table(vary, info.cases, rows, info.seeds, seed)
    return Plan(info, table, KeptFiles(info.files))
