"""Options of plots."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from pathlib import Path

from setcmas_simu.options import positive
from setcmas_tools.plots.formats import FILMS, FORMATS, PALETTES, PAPERS

BEST = 'best'
"""The kind of film that is the best on this machine."""


def add_format_argument(parser: argparse.ArgumentParser) -> None:
    """Add --format."""
    parser.add_argument(
        '--format',
        nargs='+',
        type=_one_of(FORMATS),
        choices=FORMATS,
        default=['png'],
        help='formats of the plots (default: png)',
    )


def add_style_arguments(parser: argparse.ArgumentParser) -> None:
    """Add --palette and --paper, with which plots are PDF unless --format says otherwise."""
    parser.set_defaults(format=None)
    parser.add_argument(
        '--palette',
        choices=PALETTES,
        default=PALETTES[0],
        help="colours of the robots, or Okabe and Ito's for colour-blind readers"
        ' (default: %(default)s)',
    )
    parser.add_argument(
        '--paper',
        nargs='?',
        const='column',
        type=_one_of(PAPERS),
        choices=list(PAPERS),
        help='for print in two columns, as PDF: 3.5 in wide (column, the default) or 7.16 (page)',
    )


def add_film_arguments(parser: argparse.ArgumentParser) -> None:
    """Add --animate and --speed."""
    kinds = [BEST, *FILMS]
    parser.add_argument(
        '--animate',
        nargs='?',
        const=BEST,
        type=_one_of(kinds),
        choices=kinds,
        help='write a film as well: mp4 (needs ffmpeg) or gif (default: the first that works)',
    )
    parser.add_argument(
        '--speed',
        type=positive,
        metavar='TIMES',
        help='how many times faster than the robots the film is (default: 1)',
    )


def _one_of(choices: Iterable[str]) -> Callable[[str], str]:
    """Return the type of an option that would take a folder behind it for its value."""

    def parse(text: str) -> str:
        if text not in choices and Path(text).exists():
            raise argparse.ArgumentTypeError(
                f"'{text}' is none of {', '.join(choices)}; if it is what to plot, put it first"
            )
        return text

    return parse
