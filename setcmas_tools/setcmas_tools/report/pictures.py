"""Plots of a run as pictures in the page, SVG or PNG, whichever is smaller."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from dataclasses import dataclass

from matplotlib.figure import Figure
from PIL import Image

from setcmas_tools.plots.style import plot_style
from setcmas_tools.report.pair import Pair

_DPI = 110
_COLOURS = 128
"""Enough for lines and letters with smooth edges."""


@dataclass(frozen=True)
class EmbeddedPicture:
    """A plot.

    Attributes:
        name: That of the plot.
        address: A data URL.
    """

    name: str
    address: str


def embedded_pictures(pair: Pair) -> Iterator[EmbeddedPicture]:
    """Yield the plots."""
    with plot_style():
        for name, figure in pair.figures():
            kinds = {'image/svg+xml': _svg(figure), 'image/png': _png(figure)}
            kind = min(kinds, key=lambda one: len(kinds[one]))
            content = base64.b64encode(kinds[kind]).decode('ascii')
            yield EmbeddedPicture(name, f'data:{kind};base64,{content}')


def _svg(figure: Figure) -> bytes:
    content = io.BytesIO()
    figure.savefig(content, format='svg', metadata={'Date': None})
    return content.getvalue()


def _png(figure: Figure) -> bytes:
    drawn, small = io.BytesIO(), io.BytesIO()
    figure.savefig(drawn, format='png', dpi=_DPI)
    picture = Image.open(drawn).convert('RGB')
    picture.quantize(_COLOURS, dither=Image.Dither.NONE).save(small, format='png', optimize=True)
    return small.getvalue()
