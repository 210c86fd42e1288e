"""Options of a player, the same for `setcmas play` and for the node's own command line."""

from __future__ import annotations

from dataclasses import dataclass

from setcmas_simu.options.group import Options, flag, option
from setcmas_simu.options.kinds import Kind, Number
from setcmas_simu.options.option import Form


@dataclass(frozen=True, kw_only=True)
class PlayerOptions(Options):
    """What is played of a bag, and how fast."""

    rate: float = option(
        Number(above=0, finite=True), 'how many times as fast as it was recorded', default=1.0
    )
    start: float = option(
        Number(least=0, unit='s', finite=True),
        'begin so long after the first message',
        default=0.0,
    )
    loop: bool = flag('begin again at the end, until Ctrl-C')
    topics: tuple[str, ...] | None = option(
        Kind(metavar='TOPIC'),
        'play only these',
        default=None,
        default_text='all but commands',
        form=Form.SEVERAL,
    )
    clock: bool = flag('publish the time of the recording on /clock, 40 times a second')
