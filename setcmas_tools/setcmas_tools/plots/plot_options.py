"""Options of plots and films: formats, paper and speed."""

from __future__ import annotations

from dataclasses import dataclass

from setcmas_simu.option_groups import ClashError, Form, Options, flag, option
from setcmas_simu.option_kinds import Number, OneOf

FORMATS = ('png', 'pdf', 'svg')
"""File formats by file ending: PNG at 150 dpi (600 on paper), and vector graphics."""

PAPERS = {'column': 3.5, 'page': 7.16}
"""Widths in inches of a one-column and a two-column figure in a two-column paper (IEEE)."""

FILMS = ('mp4', 'gif')
"""Kinds of films."""

BEST = 'best'
"""The best kind of film on this machine."""


@dataclass(frozen=True, kw_only=True)
class PlotOptions(Options):
    """Appearance of plots; `show` opens them in windows until the user closes them."""

    format: tuple[str, ...] | None = option(
        OneOf(FORMATS),
        'formats of the plots',
        default=None,
        default_text='png, with --paper pdf',
        form=Form.SEVERAL,
    )
    paper: str | None = option(
        OneOf(tuple(PAPERS)),
        'for print: column (3.5 inches wide; same as --paper alone) or page (7.16 inches wide)',
        default=None,
        alone='column',
    )
    show: bool = flag('open the plots in windows')

    @property
    def formats(self) -> tuple[str, ...]:
        """The formats to write."""
        return self.format or (('pdf',) if self.paper else ('png',))


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
