"""Drawing of the rooms: packages from top to bottom, each importing those below it."""

from __future__ import annotations

import ast
from pathlib import Path

import svg

ROOT = Path(__file__).parents[2]
PACKAGES = {
    'launch_scripts': ('the command setcmas', '#fff3e0'),
    'setcmas_tools': ('runs as things: record, read, measure, plot, view', '#f3e5f5'),
    'setcmas_expe': ('real robots', '#ffebee'),
    'setcmas_ctrl': ('control laws', '#e8f5e9'),
    'setcmas_simu': ('the ground, and simulated robots', '#e3f2fd'),
}
WIDTH, MARGIN, GAP = 900, 8, 10
PER_ROW, ROOM_HEIGHT, HEAD = 4, 80, 34
MODULES = 20  # height of their line


def svg_of(package: str, top: float) -> tuple[list[str], float]:
    """Return the drawing of a package, and its height."""
    purpose, fill = PACKAGES[package]
    rooms, modules = rooms_of(package)
    width = (WIDTH - 2 * MARGIN - (PER_ROW + 1) * GAP) / PER_ROW
    nb_rows = -(-len(rooms) // PER_ROW)
    head = HEAD + (MODULES if modules else 0)
    height = head + nb_rows * (ROOM_HEIGHT + GAP)
    left = MARGIN + GAP
    parts = [
        svg.box((MARGIN, top), (WIDTH - 2 * MARGIN, height), fill),
        svg.words((left, top + 22), package, 16, 'start', 'font-weight="bold"'),
        svg.words((left + 150, top + 22), purpose, 13, 'start'),
        svg.words((left, top + 43), ', '.join(modules), 12, 'start', 'font-style="italic"'),
    ]
    for index, (room, words) in enumerate(rooms.items()):
        row, column = divmod(index, PER_ROW)
        x = left + column * (width + GAP)
        y = top + head + row * (ROOM_HEIGHT + GAP)
        parts.append(svg.box((x, y), (width, ROOM_HEIGHT), 'white'))
        middle = x + width / 2
        parts.append(svg.words((middle, y + 20), room, 14, 'middle', 'font-weight="bold"'))
        parts += svg.paragraph((middle, y + 38), words, 30)
    return parts, height


def rooms_of(package: str) -> tuple[dict[str, str], list[str]]:
    """Return what each room of a package is for, and the modules that stand beside them."""
    inside = ROOT / package / package
    rooms = {path.parent.name: _first_line(path) for path in sorted(inside.glob('*/__init__.py'))}
    modules = [path.stem for path in sorted(inside.glob('*.py')) if path.stem[0] != '_']
    return rooms, modules


def _first_line(path: Path) -> str:
    docstring = ast.get_docstring(ast.parse(path.read_text())) or ''
    line = docstring.partition('\n')[0].rstrip('.').replace('`', '')
    return line.removeprefix(f'{path.parent.name.capitalize()}: ')


def picture() -> str:
    """Return the drawing."""
    parts: list[str] = []
    top = float(MARGIN)
    for package in PACKAGES:
        if parts:
            parts.append(svg.arrow([(WIDTH / 2, top), (WIDTH / 2, top + 26)]))
            parts.append(svg.words((WIDTH / 2 + 12, top + 17), 'imports', 12, 'start'))
            top += 30
        drawn, height = svg_of(package, top)
        parts += drawn
        top += height
    return svg.drawing(WIDTH, int(top + MARGIN), 'The five packages and their rooms', parts)
