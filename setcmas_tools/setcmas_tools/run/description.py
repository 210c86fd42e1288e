"""What a run was: its law and size in words, and the references of its task."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from setcmas_expe.arena import Arena
from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.files import run_parameters
from setcmas_tools.run.references import References, references, script_of_run, task_of

_LONGEST_NAME = 40


@dataclass(frozen=True)
class RunDescription:
    """What plots and films tell of a run.

    Attributes:
        title: Such as 'consensus, 8 robots'.
        references: What the robots were to reach, if the law is a built-in one.
        arena: Where they were allowed to be, in an experiment.
    """

    title: str
    references: References | None
    arena: Arena | None = None


def describe(source: Path, robots: list[int]) -> RunDescription:
    """Return what is known about the run of a fleet.csv with these robots.

    Where nothing can be read of it, this is their number: a damaged run.yaml or a script that is
    gone does not keep anybody from looking at the robots' motion.
    """
    number = f'{len(robots)} robot{"s" if len(robots) > 1 else ""}'
    script = known = arena = None
    with suppress(SetcmasError):
        parameters = run_parameters(source)
        arena = _arena(parameters.get('arena'))
        script = script_of_run(source, parameters, None)
        if task := task_of(script):
            known = references(task, script, max(robots), parameters.get('set'))
    title = f'{_short(script.stem)}, {number}' if script else number
    return RunDescription(title, known, arena)


def _arena(sides: Any) -> Arena | None:
    """Return the arena of four recorded sides in m; None if they are not that."""
    with suppress(TypeError, ValueError):
        return Arena(*map(float, sides))
    return None


def _short(name: str) -> str:
    return name if len(name) <= _LONGEST_NAME else f'{name[: _LONGEST_NAME - 1]}…'
