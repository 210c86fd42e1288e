"""Files of a study: study.yaml, the copies of its scripts, and the rows of its table."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_simu.limited_file import written_whole
from setcmas_tools.run.inputs import inputs_of, kept_record
from setcmas_tools.run.run_folder import remove_parts
from setcmas_tools.run.run_info import INFO_FILE as RUN_FILE
from setcmas_tools.run.run_info import Origin, builtins_of, read_record, this_origin, write_record
from setcmas_tools.scenario.scenario import Scenario
from setcmas_tools.scenario.scenario_files import INPUTS, OF_FILES

FILE_NAME = 'study.yaml'
TABLE = 'runs.csv'
ROWS = 'runs.jsonl'
"""Rows in the order in which runs finished, a line of JSON each: a study continues after them."""

_PARTS = (INPUTS, TABLE, ROWS, 'plots', FILE_NAME)


@dataclass(frozen=True)
class StudyInfo:
    """Content of study.yaml.

    Attributes:
        scenario: The common scenario of its runs, as from `Scenario.record`.
        cases: Values by name that vary together.
        vary: Values of each varied name.
        seeds: Number of seeds; the first one is the scenario's.
        files: Paths of stored files in the folder, by option and original text.
        metrics: SHA-256 of the source of its own metrics, by name.
        origin: Versions that made it; None if not recorded yet.
    """

    scenario: dict[str, Any]
    cases: list[dict[str, Any]] = field(default_factory=list)
    vary: dict[str, Any] = field(default_factory=dict)
    seeds: int = 1
    files: dict[str, dict[str, str]] = field(default_factory=dict)
    metrics: dict[str, str] = field(default_factory=dict)
    origin: Origin | None = None


def read_info(folder: Path) -> StudyInfo | None:
    """Read the study.yaml of a folder, None if there is none; raise SetcmasError if damaged."""
    return read_record(folder / FILE_NAME, StudyInfo)


@dataclass
class KeptFiles:
    """Scripts and files that a study stores.

    Attributes:
        texts: Replacement of each text that names files, by option: with 'inputs/...' instead.
        contents: Content by 'inputs/...', including modules that scripts import.
    """

    texts: dict[str, dict[str, str]] = field(default_factory=dict)
    contents: dict[str, bytes] = field(default_factory=dict)
    _seen: set[tuple[str, str]] = field(default_factory=set)

    def add(self, scenario: Scenario) -> None:
        """Store the files that a scenario names; raise SetcmasError if one is missing."""
        values = scenario.values().items()
        named = {n: str(v) for n, v in values if n in OF_FILES and isinstance(v, (str, Path))}
        if named.items() <= self._seen:
            return
        self._seen |= named.items()
        found = scenario.found()
        inputs = inputs_of(found)
        record = kept_record(found, inputs)
        for name, text in named.items():
            if record[name] != text:
                self.texts.setdefault(name, {})[text] = record[name]
        for one in inputs:
            for file, content in zip(one.files, one.contents, strict=True):
                path = f'{one.folder}/{file.relative_to(one.path.parent).as_posix()}'
                if self.contents.setdefault(path, content) != content:
                    raise SetcmasError(
                        f"'{file}' and another file would both be stored as '{path}'; rename one"
                    )


def prepare(
    folder: Path, info: StudyInfo, files: Mapping[str, bytes], overwrite: bool = False
) -> None:
    """Create the folder of a study with its files, or check that it holds the same one.

    Raises SetcmasError if it holds something else, and not a study to `overwrite`.
    """
    wanted = replace(info, origin=this_origin())
    if overwrite and (folder / FILE_NAME).is_file():
        remove_parts(folder, _PARTS)
    _refuse_others(folder)
    earlier = read_info(folder)
    if earlier and (name := _difference(earlier, wanted) or _changed(folder, files)):
        raise SetcmasError(
            f"output '{folder}' holds another study ({name} differs); choose another "
            'folder, or add --overwrite'
        )
    for name, content in {} if earlier else files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    folder.mkdir(parents=True, exist_ok=True)
    if earlier is None or earlier.seeds != wanted.seeds:
        (folder / TABLE).unlink(missing_ok=True)  # until the new runs have their rows, too
        write_record(wanted, folder / FILE_NAME)


def _refuse_others(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise SetcmasError(f"output '{folder}' is not a folder")
    taken = [part for part in (*_PARTS, RUN_FILE) if (folder / part).exists()]
    if taken and FILE_NAME not in taken:
        raise SetcmasError(
            f"output '{folder}' holds {', '.join(taken)} but no {FILE_NAME}, so it is "
            'not a study; choose another folder'
        )


def _difference(earlier: StudyInfo, wanted: StudyInfo) -> str:
    """Return the first difference between two studies that changes rows; '' if none."""
    first, second = _compared(earlier), _compared(wanted)
    if earlier.seeds < wanted.seeds:  # whose runs come after the others
        del first['seeds']
    return next((name for name, value in first.items() if value != second[name]), '')


def _changed(folder: Path, files: Mapping[str, bytes]) -> str:
    """Return the first file whose copy in the folder differs; '' if none."""
    paths = {name: folder / name for name in files}
    return next((n for n, p in paths.items() if not p.exists() or p.read_bytes() != files[n]), '')


def _compared(study: StudyInfo) -> dict[str, Any]:
    plain: dict[str, Any] = {**dict.fromkeys(vars(study)), **builtins_of(study)}
    parameters = {f'--{name}': value for name, value in plain.pop('scenario').items()}
    origin = plain.pop('origin') or {}
    return {**parameters, **plain, 'setcmas': origin.get('setcmas')}


def finished_rows(folder: Path) -> dict[int, dict[str, Any]]:
    """Return the rows of a study so far, by run; runs with damaged lines are to be made again."""
    rows = {}
    for line in (folder / ROWS).read_bytes().splitlines() if (folder / ROWS).exists() else []:
        with suppress(ValueError, KeyError, TypeError):
            row = json.loads(line)
            rows[row['run']] = row
    return rows


def stored_rows(folder: Path, rows: Iterable[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield rows as they come, each once it is in the file."""
    with (folder / ROWS).open('a', encoding='utf-8') as file:
        file.write('\n' if file.tell() else '')  # ends a line that a killed study left
        for row in rows:
            file.write(json.dumps(row) + '\n')
            file.flush()
            yield row


def write_table(table: Any, folder: Path) -> None:
    """Write runs.csv from a pandas table, whole or not at all."""
    with written_whole(folder / TABLE) as file:
        table.to_csv(file, index=False, float_format='%.9g', lineterminator='\n')
