"""Options of the doctor."""

from __future__ import annotations

from dataclasses import dataclass

from setcmas_simu.options.group import Options, flag


@dataclass(frozen=True, kw_only=True)
class DoctorOptions(Options):
    """What the doctor does besides looking."""

    nudge: bool = flag(
        'nudge each robot without asking, 5 cm forward and back, and a small turn; clear the way '
        'first'
    )
