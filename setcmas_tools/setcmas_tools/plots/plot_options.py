"""Options of plots and films: formats and speed."""

from __future__ import annotations

from dataclasses import dataclass

from setcmas_simu.option_groups import ClashError, Form, Options, flag, option
from setcmas_simu.option_kinds import Number, OneOf

FORMATS = ('png', 'pdf', 'svg')
"""File formats by file ending: PNG at 150 dpi, and vector graphics."""

FILMS = ('mp4', 'gif')
"""Kinds of films."""

BEST = 'best'
"""The best kind of film on this machine."""


@dataclass(frozen=True, kw_only=True)
class PlotOptions(Options):
    """Appearance of plots; `show` opens them in windows until the user closes them."""

    format: tuple[str, ...] = option(
        OneOf(FORMATS), 'formats of the plots', default=('png',), form=Form.SEVERAL
    )
    show: bool = flag('open the plots in windows')


@dataclass(frozen=True, kw_only=True)
class FilmOptions(Options):
    """Options of films."""

    animate: str | None = option(
        OneOf((BEST, *FILMS)),
        'also write a video: mp4 (needs ffmpeg), gif, or best: mp4 if possible, else gif',
        default=None,
        alone=BEST,
    )
    speed: float = option(
        Number(above=0, finite=True, metavar='TIMES'),
        'playback speed, in multiples of real time',
        default=1.0,
    )

    def check(self) -> None:
        """Check that options of films come with --animate."""
        if not self.animate and (changed := list(self.changed())):
            raise ClashError('{} is for videos; add {}', changed[0], 'animate')
