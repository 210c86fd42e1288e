"""The folder of a study: study.yaml, inputs/, runs.csv, runs.jsonl and plots/."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.run_folder import remove_parts
from setcmas_tools.run.run_info import INFO_FILE as RUN_FILE
from setcmas_tools.run.run_info import builtins_of, this_origin
from setcmas_tools.scenario.scenario_files import INPUTS
from setcmas_tools.study import study_files, study_table
from setcmas_tools.study.study_files import StudyInfo, read_info, write_info
from setcmas_tools.study.study_plan import Plan

_PARTS = (INPUTS, study_table.FILE_NAME, study_table.ROWS, 'plots', study_files.FILE_NAME)


@contextmanager
def written(folder: Path) -> Iterator[None]:
    """Report errors of files in a study's folder in one line.

    Raises:
        SetcmasError: A file cannot be written.
    """
    try:
        yield
    except OSError as error:
        raise SetcmasError(f"study '{folder}' cannot be written: {error.strerror}") from error


def prepare(folder: Path, plan: Plan, overwrite: bool = False) -> None:
    """Create the folder of a study, or check that it holds the same one.

    Args:
        folder: The folder.
        plan: The study.
        overwrite: Whether to overwrite another study.

    Raises:
        SetcmasError: The folder holds something else, or cannot be written.
    """
    wanted = replace(plan.info, origin=this_origin())
    with written(folder):
        if overwrite and (folder / study_files.FILE_NAME).is_file():
            remove_parts(folder, _PARTS)
        _refuse_others(folder)
        earlier = read_info(folder)
        if earlier and (name := _difference(earlier, wanted)):
            raise SetcmasError(
                f"output '{folder}' holds another study ({name} differs); choose another "
                'folder, or add --overwrite'
            )
        if not earlier:
            folder.mkdir(parents=True, exist_ok=True)
            plan.files.write_to(folder)
        if earlier and earlier.seeds < wanted.seeds:  # until the new runs have their rows, too
            (folder / study_table.FILE_NAME).unlink(missing_ok=True)
        if not earlier or (earlier.success, earlier.seeds) != (wanted.success, wanted.seeds):
            write_info(wanted, folder)


def _refuse_others(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise SetcmasError(f"output '{folder}' is not a folder")
    taken = [part for part in (*_PARTS, RUN_FILE) if (folder / part).exists()]
    if taken and study_files.FILE_NAME not in taken:
        raise SetcmasError(
            f"output '{folder}' holds {', '.join(taken)} but no {study_files.FILE_NAME}, so it is "
            'not a study; choose another folder'
        )


def _difference(earlier: StudyInfo, wanted: StudyInfo) -> str:
    """Return the first difference between two studies that changes rows; '' if none."""
    first, second = _compared(earlier), _compared(wanted)
    if earlier.seeds < wanted.seeds:  # whose runs come after the others
        del first['seeds']
    return next((name for name, value in first.items() if value != second[name]), '')


def _compared(study: StudyInfo) -> dict[str, Any]:
    plain: dict[str, Any] = {**dict.fromkeys(vars(study)), **builtins_of(study)}
    parameters = {f'--{name}': value for name, value in plain.pop('scenario').items()}
    origin = plain.pop('origin') or {}
    del plain['success']
    return {**parameters, **plain, 'setcmas': origin.get('setcmas')}
