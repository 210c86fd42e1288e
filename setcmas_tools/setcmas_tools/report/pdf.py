"""Report of a run on paper: figures and command, the plots, the scripts with their failures."""

from __future__ import annotations

import textwrap
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from setcmas_tools.plots.looks.style import plot_style
from setcmas_tools.report.facts import facts_of
from setcmas_tools.report.listing import Listing, Mark, listings
from setcmas_tools.report.pair import Pair

_A4_IN = (8.27, 11.69)
_LEFT, _TOP, _LINE = 0.08, 0.93, 0.0115
_LINES = 74
_WIDTH = 110  # letters
Line = tuple[str, str]
"""A text and its colour."""


def write_pdf(pair: Pair, path: Path) -> None:
    """Write a run as PDF.

    Args:
        pair: The run, and perhaps another one beside it.
        path: The file.

    Raises:
        OSError: It cannot be written.
    """
    title = {'Title': pair.run.title, 'Creator': 'setcmas', 'CreationDate': None}
    with plot_style(), warnings.catch_warnings(), PdfPages(path, metadata=title) as pdf:
        warnings.filterwarnings('ignore', 'Glyph .* missing')  # a letter without a font
        for page in _pages(pair.run.title, _title_lines(pair)):
            pdf.savefig(page)
        for _, figure in pair.figures():
            pdf.savefig(figure)
        for listing in listings(pair.run):
            for page in _pages(f'{listing.name}: {listing.what}', _listing_lines(listing)):
                pdf.savefig(page)


def _title_lines(pair: Pair) -> Iterator[Line]:
    facts = facts_of(pair.run)
    yield f'{pair.name}, {facts.line}', '0.4'
    yield facts.outcome, 'black' if facts.well else 'firebrick'
    for mark in facts.failures:
        yield f'  {mark.place}: {_told(mark)}', 'firebrick'
    table, remarks = pair.metrics('simple')
    told = ['', *table.splitlines(), *remarks, '', facts.command, '']
    if pair.verdict:
        told += [pair.verdict.title, *pair.verdict.lines, '']
    told += [pair.beside, *pair.differences, ''] if pair.other else []
    yield from ((line, 'black') for line in told)
    yield from ((f'{key}: {value}', '0.4') for key, value in facts.origin.items())


def _listing_lines(listing: Listing) -> Iterator[Line]:
    for number, (text, marks) in enumerate(listing.lines, 1):
        yield f'{number:4d}  {text}', 'firebrick' if marks else 'black'
        yield from ((f'      {_told(mark)}', 'firebrick') for mark in marks)


def _told(mark: Mark) -> str:
    return f'{mark.robots}, {mark.when}: {mark.text}'


def _pages(title: str, lines: Iterator[Line]) -> Iterator[Figure]:
    """Yield pages with a title and lines of text, long ones broken."""
    broken = [(part, colour) for text, colour in lines for part in _broken(text)]
    for first in range(0, max(1, len(broken)), _LINES):
        figure = Figure(figsize=_A4_IN)
        figure.set_layout_engine('none')
        look: dict[str, Any] = {'parse_math': False}
        figure.text(_LEFT, _TOP + 2 * _LINE, title, fontsize=14, **look)
        for place, (text, colour) in enumerate(broken[first : first + _LINES]):
            where = _TOP - place * _LINE
            figure.text(_LEFT, where, text, fontsize=7.5, color=colour, family='monospace', **look)
        yield figure


def _broken(text: str) -> list[str]:
    indent = ' ' * min(20, len(text) - len(text.lstrip()) + 8)
    return textwrap.wrap(
        text, _WIDTH, subsequent_indent=indent, drop_whitespace=False, tabsize=4
    ) or ['']
