"""Another task, or another largest speed, for a run than it tells of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from setcmas_ctrl.scripts.loader import find_script
from setcmas_ctrl.scripts.plain_values import plain_values
from setcmas_ctrl.task.references import checked_references
from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.run import Run


def with_task(run: Run, task: str | None, algo: str | None = None) -> Run:
    """Return a run with the references that a control script has in plain values.

    The script is read, not run: `WPL = [[1, 1], [2, 2]]` is a plain value, what it
    computes is not.

    Args:
        run: The run.
        task: Name of the task; by default that of the script.
        algo: The script, as for `--algo`; by default that of the run, with its `--set`.

    Raises:
        SetcmasError: There is no such script or task, or a reference is missing.
    """
    script = find_script(algo) if algo else _own_script(run)
    given: dict[str, Any] = plain_values(script) if script else {}
    if not algo:
        known = run.references.values if run.references else {}
        given |= {**known, **run.parameters.get('set', {})}
    task = task or _stated(given, script)
    if script is None and task != 'consensus':
        raise SetcmasError(
            f"task '{task}' has references in the control script, which no run.yaml names; "
            'name it with --algo'
        )
    name = script.name if script else 'the run'
    references = checked_references(task, given, name)
    return replace(run, tables=replace(run.tables, references=references))


def with_vnom(run: Run, vnom: float) -> Run:
    """Return a run with another largest speed that was asked of robots, in m/s."""
    parameters = {**run.parameters, 'vnom': vnom, 'model': None, 'limits': 'ideal'}
    return replace(run, info=replace(run.info, parameters=parameters))


def _own_script(run: Run) -> Path | None:
    return next((given.path for given in run.inputs if given.option == 'algo'), None)


def _stated(given: Mapping[str, Any], script: Path | None) -> str:
    task = given.get('task')
    if not isinstance(task, str):
        name = script.name if script else 'the run'
        raise SetcmasError(f'{name} says no task; name it with --task')
    return task
