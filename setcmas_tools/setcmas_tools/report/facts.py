"""Facts of a run in words: its outcome, its command, what it was made with."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from typing import Any

from setcmas_tools.compare.run_distance import flat
from setcmas_tools.report.listing import Mark, marks_of
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import State


@dataclass(frozen=True)
class Facts:
    """What is told of a run in words.

    Attributes:
        line: Duration and date.
        outcome: How it ended.
        well: Whether that is well.
        detail: What there is to say beyond.
        failures: What went wrong in scripts.
        links: Whether there is a record of communication.
        command: The command line; empty if there was none.
        origin: What it was made with, by name.
        parameters: The options that are set, by name.
    """

    line: str
    outcome: str
    well: bool
    detail: str
    failures: list[Mark]
    links: bool
    command: str
    origin: dict[str, Any]
    parameters: dict[str, Any]


def facts_of(run: Run) -> Facts:
    """Return the facts of a run."""
    info = run.info
    duration = float(run.table.t[-1]) - max(0.0, float(run.table.t[0]))
    began = f'{round(duration, 1):g} s', (info.started or '').replace('T', ' ').partition('+')[0]
    kept = {key: value for key, value in flat(info.parameters).items() if value not in (None, [])}
    outcome = str(run.outcome).partition('\n')[0]
    return Facts(
        line=', begun '.join(part for part in began if part),
        outcome=outcome,
        well=run.outcome.state is State.COMPLETE,
        detail='' if run.outcome.detail in outcome else run.outcome.detail,
        failures=marks_of(info.failures or []),
        links=run.record is not None,
        command=shlex.join(info.command),
        origin=_origin(run),
        parameters=kept,
    )


def _origin(run: Run) -> dict[str, Any]:
    origin = run.info.origin
    told = {'setcmas': origin.setcmas, **origin.versions, **origin.host} if origin else {}
    names = {'name': 'computer'}
    return {names.get(key, key): value for key, value in told.items()} | {'seed': run.info.seed}
