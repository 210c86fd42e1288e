"""Options of a recorder, the same for `setcmas record` and for the node's own command line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from setcmas_simu.options.group import Options, option
from setcmas_simu.options.kinds import Kind, PathTo
from setcmas_simu.options.option import Form


@dataclass(frozen=True, kw_only=True)
class RecorderOptions(Options):
    """What is recorded, and into which bag."""

    output: Path = option(PathTo(metavar='DIR'), 'folder of the bag, to be created', short='-o')
    topics: tuple[str, ...] | None = option(
        Kind(metavar='TOPIC'),
        'record only these',
        default=None,
        default_text='all',
        form=Form.SEVERAL,
    )
