"""Options of communication, for every command that runs control laws."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from numpy.typing import ArrayLike

from setcmas_ctrl.communication.graph import COMPLETE, PRESETS
from setcmas_ctrl.communication.triggering import CTC, THRESHOLD_M
from setcmas_ctrl.scripts.exercise import unfilled_note
from setcmas_ctrl.scripts.loader import EXERCISES
from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.completion import names_and_files
from setcmas_simu.options.group import ClashError, Options, flag, option
from setcmas_simu.options.kinds import LENGTH, NameOrFile, Number

Graph = str | Path | ArrayLike
Condition = str | Path | Callable[..., Any] | Mapping[int, Callable[..., Any]] | None


@dataclass(frozen=True)
class _Condition(NameOrFile):
    """A script; in Python also a function, or one for each robot."""

    def value(self, given: Any) -> Any:
        """Return a path as a text."""
        return str(given) if isinstance(given, Path) else given

    def accepts(self, value: Any) -> bool:
        """Return True: errors of a condition are raised where it is loaded."""
        return value is not None


@dataclass(frozen=True)
class _Graph(NameOrFile):
    """A name or a file; in Python also a matrix."""

    def value(self, given: Any) -> Any:
        """Return a path as a text."""
        return str(given) if isinstance(given, Path) else given

    def located(self, value: Any, place: Callable[[str], str]) -> Any:
        """Return a file in its place."""
        names_file = isinstance(value, str) and ('.' in value or '/' in value)
        return place(value) if names_file else value

    def accepts(self, value: Any) -> bool:
        """Return True: errors of a graph are raised where it is read."""
        return value is not None


@dataclass(frozen=True, kw_only=True)
class CommunicationOptions(Options):
    """Graph, event triggering, and quality of the links."""

    TITLE: ClassVar[str] = 'communication (default: all robots know all poses)'

    event_triggered: bool = flag('robots send their state only when a condition triggers')
    ctc: Condition = option(
        _Condition(metavar='FILE'),
        'script with the triggering condition ctc(pos, last_pos, t): a path or a name',
        default=None,
        default_text='send at a distance of --threshold from the last position sent',
    )
    threshold: float = option(
        LENGTH,
        'without --ctc: send at this distance from the last position sent',
        default=THRESHOLD_M,
    )
    graph: Graph = option(
        _Graph(metavar='NAME|FILE.yaml'),
        f'communication graph: {", ".join(PRESETS)}, or a file',
        default=COMPLETE,
        complete=names_and_files(lambda: PRESETS, ('yaml', 'yml')),
    )
    range: float | None = option(Number(above=0, unit='m'), 'range of the links', default=None)
    delay: float = option(
        Number(least=0, unit='s', finite=True), 'delay of each message', default=0.0
    )
    loss: float = option(
        Number(least=0, most=1, metavar='P'), 'probability that a message is lost', default=0.0
    )
    noise: float = option(
        Number(least=0, unit='m', finite=True),
        'standard deviation of received positions',
        default=0.0,
    )

    def check(self) -> None:
        """Check that a condition and a threshold have an effect."""
        if self.ctc is not None and not self.event_triggered:
            raise ClashError('{} needs {}; add it', 'ctc', 'event_triggered')
        if self.threshold != THRESHOLD_M and not self.event_triggered:
            raise ClashError('{} needs {}; add it', 'threshold', 'event_triggered')
        if self.threshold != THRESHOLD_M and self.ctc is not None:
            raise ClashError('{} has its own threshold; remove {}', 'ctc', 'threshold')

    def found(self, exercise: bool = False) -> CommunicationOptions:
        """Return the same with the file of the script that `ctc` names.

        Args:
            exercise: Whether it may be the name of an exercise.

        Raises:
            SetcmasError: There is no such script.
        """
        if not isinstance(self.ctc, (str, Path)):
            return self
        return replace(self, ctc=find_condition(str(self.ctc), exercise))

    @property
    def notes(self) -> list[str]:
        """What to say of a condition that was found and is not filled in yet."""
        note = unfilled_note(self.ctc) if isinstance(self.ctc, Path) else ''
        return [note] if note else []


def find_condition(name: str, exercise: bool = False) -> Path:
    """Return the script that `--ctc NAME` means.

    In this order: a path to a file; NAME.py in the current folder; if `exercise`, an exercise.

    Raises:
        SetcmasError: There is none.
    """
    for path in (Path(name), Path(f'{name}.py')):
        if path.is_file():
            return path.resolve()
    if exercise and name in EXERCISES:
        return EXERCISES.file(name)
    raise SetcmasError(
        f"script '{name}' of --ctc was not found; it must be a path, or the name of a script "
        f'in this folder with a function {CTC}'
    )
