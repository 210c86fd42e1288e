"""Options of grading a class."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from setcmas_simu.options.group import Options, flag, option
from setcmas_simu.options.kinds import DURATION, Number, Whole
from setcmas_tools.study.study_options import cores


@dataclass(frozen=True, kw_only=True)
class GradeOptions(Options):
    """How submissions are graded."""

    TITLE: ClassVar[str] = 'grading'

    jobs: int = option(
        Whole(1), 'submissions graded at once', default=cores(), default_text='the number of cores'
    )
    trust: bool = flag(
        'run submissions without the sandbox: they can then do whatever you can; needed on '
        'systems where bubblewrap cannot confine them (macOS, Windows)'
    )
    call_timeout: float = option(
        Number(above=0, unit='s'), 'time limit of a call of the script', default=10.0
    )
    timeout: float = option(DURATION, 'time limit of a run', default=60.0)
    overwrite: bool = flag(
        'grade again those already graded, and replace files that were changed by hand'
    )
