"""Boxes, arrows and words of the drawings, as SVG."""

from __future__ import annotations

import textwrap
from html import escape

INK = '#263238'
GREY = '#607d8b'
FONT = 'Roboto, Helvetica, Arial, sans-serif'
Point = tuple[float, float]


def drawing(width: int, height: int, title: str, parts: list[str]) -> str:
    """Return an SVG file; the title is for those who do not see it."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'width="{width}" height="{height}" role="img" font-family="{FONT}">\n'
        f'<title>{escape(title)}</title>\n'
        '<defs><marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" '
        f'markerHeight="7" orient="auto-start-reverse"><path d="M0,0 L10,5 L0,10 z" fill="{INK}"/>'
        '</marker></defs>\n'
        f'<rect width="{width}" height="{height}" fill="white"/>\n'
        + '\n'.join(parts)
        + '\n</svg>\n'
    )


def box(corner: Point, size: Point, fill: str, stroke: str = GREY) -> str:
    """Return a box with round corners; its corner is the upper left one."""
    (x, y), (width, height) = corner, size
    return (
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="6" '
        f'fill="{fill}" stroke="{stroke}"/>'
    )


def words(at: Point, text: str, size: int = 13, anchor: str = 'middle', style: str = '') -> str:
    """Return a line of text; `at` is on its base line."""
    x, y = at
    return (
        f'<text x="{x:g}" y="{y:g}" font-size="{size}" text-anchor="{anchor}" '
        f'fill="{INK}" {style}>{escape(text)}</text>'
    )


def paragraph(at: Point, text: str, columns: int, size: int = 12) -> list[str]:
    """Return a text in lines of that many characters, centred."""
    x, y = at
    lines = textwrap.wrap(text, columns)
    return [words((x, y + 1.3 * size * row), line, size) for row, line in enumerate(lines)]


def arrow(points: list[Point], dashed: bool = False) -> str:
    """Return a line through points with a tip at its end."""
    path = ' '.join(f'{x:g},{y:g}' for x, y in points)
    dashes = ' stroke-dasharray="5 4"' if dashed else ''
    return (
        f'<polyline points="{path}" fill="none" stroke="{INK}" stroke-width="1.4"{dashes} '
        'marker-end="url(#tip)"/>'
    )
