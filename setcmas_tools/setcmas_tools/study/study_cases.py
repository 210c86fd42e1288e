"""Cases of a study: all combinations of varied values, for each seed."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_tools.study.variation import Draw

SEED = 'seed'


@dataclass(frozen=True)
class CaseTable:
    """The runs of a study, numbered from 1: the last axis varies fastest, seeds vary slowest.

    So more seeds add runs at the end, and the others keep their numbers.

    Attributes:
        axes: Names that vary together, and their values, a tuple per case.
        draws: Random values that each run draws, by name.
        seeds: Number of seeds.
    """

    axes: Sequence[tuple[tuple[str, ...], Sequence[tuple[Any, ...]]]] = ()
    draws: Mapping[str, Draw] = field(default_factory=dict)
    seed: int = 0
    seeds: int = 1

    def __len__(self) -> int:
        return self.nb_cases * self.seeds

    @property
    def nb_cases(self) -> int:
        """Number of runs with each seed."""
        return math.prod(len(values) for _, values in self.axes)

    @property
    def names(self) -> list[str]:
        """Varied names, without the seeds."""
        found = [name for names, _ in self.axes for name in names] + list(self.draws)
        return [name for name in found if name != SEED]

    def values(self, run: int) -> dict[str, Any]:
        """Return the values of a run: one for each varied name, and its seed.

        Raises:
            SetcmasError: The run does not exist.
        """
        if not 1 <= run <= len(self):
            raise SetcmasError(f'unknown run {run}; must be from 1 to {len(self)}')
        seed, rest = divmod(run - 1, self.nb_cases)
        found: dict[str, Any] = {}
        for names, values in reversed(self.axes):
            rest, index = divmod(rest, len(values))
            found |= zip(names, values[index], strict=True)
        for name, draw in self.draws.items():
            (found[name],) = draw.numbers(1, self.seed, run, *name.encode())
        found.setdefault(SEED, self.seed + seed)
        return {name: found[name] for name in (*self.names, SEED)}


def read_cases(path: Path) -> tuple[list[str], dict[int, list[str]]]:
    """Read a CSV file of cases: its names, and its rows by line.

    Raises:
        SetcmasError: The file cannot be read, or is no table.
    """
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
    heads = rows.pop(min(rows))
    for line, row in rows.items():
        if len(row) != len(heads):
            raise SetcmasError(
                f"cases '{path}', line {line} has {len(row)} cells; it must have "
                f'{len(heads)}, as the first line'
            )
    return heads, rows


@contextmanager
def located_at(path: Path | None, line: int | None) -> Iterator[None]:
    """Add file and line of a case to errors; without a line, change nothing.

    Raises:
        SetcmasError: An error about the case.
    """
    try:
        yield
    except SetcmasError as error:
        if line is None:
            raise
        text = str(error).removeprefix('--vary ')
        raise SetcmasError(f"cases '{path}', line {line}: {text}") from error
