"""Options of grading a class."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from setcmas_simu.options.group import ClashError, Options, flag, option
from setcmas_simu.options.kinds import DURATION, Number, Whole
from setcmas_tools.study.study_options import cores


@dataclass(frozen=True, kw_only=True)
class GradeOptions(Options):
    """How submissions are graded."""

    TITLE: ClassVar[str] = 'grading'

    jobs: int = option(
        Whole(1), 'submissions at a time', default=cores(), default_text='the number of cores'
    )
    trust: bool = flag(
        'run submissions without a sandbox: they can do whatever you can; where the system has '
        'none (Linux before 5.19, macOS) there is no other way'
    )
    call_timeout: float = option(
        Number(above=0, unit='s'), 'end a run if a call of the script takes longer', default=10.0
    )
    timeout: float = option(DURATION, 'end a run if all of it takes longer', default=60.0)
    emulate: bool = flag(
        'run submissions in the emulated lab, one after the other, in real time, where safety is '
        'measured too; outside of the sandbox: add --trust'
    )
    overwrite: bool = flag('grade again what is graded already')

    def check(self) -> None:
        """See that nobody runs submissions without a sandbox by mistake."""
        if self.emulate and not self.trust:
            raise ClashError(
                '{} runs submissions outside of the sandbox, so they can do whatever you can; '
                'add {} if you trust them',
                'emulate',
                'trust',
            )
