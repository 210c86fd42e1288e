"""Options of recorder and player."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from setcmas_simu.option_groups import Form, Options, option
from setcmas_simu.option_kinds import Kind, Number, PathTo
from setcmas_simu.simulation_options import ClockOptions


@dataclass(frozen=True, kw_only=True)
class RecorderOptions(ClockOptions):
    """Topics to record, their time, and the bag."""

    TITLE: ClassVar[str] = ''

    output: Path = option(PathTo(metavar='DIR'), 'folder for the bag; must not exist', short='-o')
    topics: tuple[str, ...] | None = option(
        Kind(metavar='TOPIC'),
        'record only these',
        default=None,
        default_text='all',
        form=Form.SEVERAL,
    )


@dataclass(frozen=True, kw_only=True)
class PlayerOptions(Options):
    """How fast to play."""

    rate: float = option(Number(above=0, finite=True), 'playback speed', default=1.0)
