"""Sheets to print: tags of robots and of the floor, a board for the lens, and a ruler on each."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from setcmas_expe.camera.tag_detection import MARGIN, MODULES, Picture, tag_family
from setcmas_simu.errors import needs

with needs('camera'):
    import cv2

PAPERS = {'a4': (210.0, 297.0), 'letter': (215.9, 279.4)}
"""Width and height in mm."""
FIRST_FLOOR_TAG = 501
"""Number of the first tag on the floor; robots have the numbers below it."""
SMALLEST_MM = 20.0
BOARD = (5, 7)
"""Squares across and down the ChArUco board."""
BOARD_SQUARE_MM = 33.0
_BOARD_MARKER_MM = 25.0

_EDGE_MM = 10.0
"""Edge of the paper on which printers do not print."""
_RULER_MM = 20.0
"""Height of the ruler at the bottom of each page."""
_STRIP_MM = 12.0
"""Height of the strip with number and arrow, in front of the tag."""
_GAP_MM = 5.0
_CUT_MM = 4.0
_PER_INCH = 25.4
_BOARD_PX_PER_MM = 8


def largest_size(paper: str) -> float:
    """Return the largest size in mm of a tag that fits a paper."""
    width, height = PAPERS[paper]
    free = min(width - 2 * _EDGE_MM, height - 2 * _EDGE_MM - _RULER_MM - _STRIP_MM)
    return float(np.floor(free / _with_margin(1.0)))


def pages(nb_robots: int, nb_floor_tags: int, size: float, paper: str) -> Iterator[Figure]:
    """Yield the pages: tags of the robots 1 to N and of the floor, and last the board.

    Args:
        nb_robots: Number of robots.
        nb_floor_tags: Number of floor tags.
        size: Side of the black squares in mm.
        paper: A key of PAPERS.
    """
    tags = [(number, f'robot {number}', True) for number in range(1, nb_robots + 1)]
    ends = range(FIRST_FLOOR_TAG, FIRST_FLOOR_TAG + nb_floor_tags)
    tags += [(number, f'floor {number}', False) for number in ends]
    places = list(_places(size, paper))
    for start in range(0, len(tags), len(places)):
        figure, page = _page(paper)
        for (x, y), tag in zip(places, tags[start:], strict=False):
            _draw_tag(page, x, y, size, tag)
        yield figure
    figure, page = _page(paper)
    _draw_board(page, paper)
    yield figure


def write_sheets(path: Path, sheets: Iterable[Figure]) -> int:
    """Write pages as a PDF file, whole or not at all, and return their number.

    Raises:
        OSError: The file cannot be written.
    """
    part = path.with_name(f'.{path.name}.part')
    count = 0
    try:
        with PdfPages(part) as pdf:
            for count, sheet in enumerate(sheets, start=1):  # noqa: B007
                pdf.savefig(sheet)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
    return count


def board() -> cv2.aruco.CharucoBoard:
    """Return the ChArUco board of the sheets, with lengths in m."""
    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    return cv2.aruco.CharucoBoard(BOARD, BOARD_SQUARE_MM / 1e3, _BOARD_MARKER_MM / 1e3, family)


def _with_margin(size: float) -> float:
    return size * (1 + 2 * MARGIN / MODULES)


def _places(size: float, paper: str) -> Iterator[tuple[float, float]]:
    """Yield the lower left corners in mm of the parts to cut out of a page."""
    width, height = PAPERS[paper]
    across = _with_margin(size)
    down = across + _STRIP_MM
    free = width - 2 * _EDGE_MM, height - 2 * _EDGE_MM - _RULER_MM
    nb_columns = int((free[0] + _GAP_MM) // (across + _GAP_MM))
    nb_rows = int((free[1] + _GAP_MM) // (down + _GAP_MM))
    left = (width - nb_columns * across - (nb_columns - 1) * _GAP_MM) / 2
    for row in range(nb_rows):
        for column in range(nb_columns):
            y = height - _EDGE_MM - down - row * (down + _GAP_MM)
            yield left + column * (across + _GAP_MM), y


def _page(paper: str) -> tuple[Figure, Axes]:
    """Return a page whose axes are in mm, with the ruler."""
    width, height = PAPERS[paper]
    figure = Figure(figsize=(width / _PER_INCH, height / _PER_INCH))
    page = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    page.set(xlim=(0, width), ylim=(0, height))
    page.set_axis_off()
    left, y = (width - 100) / 2, _EDGE_MM + 10
    page.plot([left, left + 100], [y, y], color='black', linewidth=0.5)
    for x in range(0, 101, 10):
        page.plot([left + x] * 2, [y, y + (4 if x % 50 == 0 else 2.5)], 'k', linewidth=0.5)
    text = 'print at 100 %: this ruler must be 100 mm long'
    page.text(width / 2, y - 3, text, ha='center', va='top', fontsize=8)
    return figure, page


def _draw_tag(page: Axes, x: float, y: float, size: float, tag: tuple[int, str, bool]) -> None:
    """Draw a tag with its cut marks; its lower left corner is x, y in mm."""
    number, label, has_front = tag
    across = _with_margin(size)
    _draw_cut_marks(page, x, y, across, across + _STRIP_MM)
    margin = (across - size) / 2
    bits = cv2.aruco.generateImageMarker(tag_family(), number, MODULES)
    _draw_squares(page, np.asarray(bits, np.uint8), x + margin, y + margin, size / MODULES)
    middle = y + across + _STRIP_MM / 2
    page.text(x + 2, middle, label, ha='left', va='center', fontsize=9)
    if has_front:
        base, tip = y + across + 1, y + across + _STRIP_MM - 1.5
        page.fill([x + across / 2 + d for d in (-6, 6, 0)], [base, base, tip], color='black')
        page.text(x + across - 2, middle, 'front', ha='right', va='center', fontsize=9)


def _draw_squares(page: Axes, bits: Picture, x: float, y: float, side: float) -> None:
    """Draw the black squares of a tag, row by row from the top, each row's runs as one piece."""
    nb_rows = len(bits)
    for row in range(nb_rows):
        ends = np.flatnonzero(np.diff(np.r_[0, bits[row] == 0, 0]))
        for begin, end in ends.reshape(-1, 2):
            corner = (x + begin * side, y + (nb_rows - 1 - row) * side)
            page.add_patch(Rectangle(corner, (end - begin) * side, side, color='black', lw=0))


def _draw_cut_marks(page: Axes, x: float, y: float, width: float, height: float) -> None:
    for corner_x, out_x in ((x, -1), (x + width, 1)):
        for corner_y, out_y in ((y, -1), (y + height, 1)):
            for dx, dy in ((out_x, 0), (0, out_y)):
                xs, ys = [corner_x, corner_x + _CUT_MM * dx], [corner_y, corner_y + _CUT_MM * dy]
                page.plot(xs, ys, color='0.5', linewidth=0.4)


def _draw_board(page: Axes, paper: str) -> None:
    width, height = PAPERS[paper]
    across, down = (BOARD_SQUARE_MM * count for count in BOARD)
    pixels = (round(across * _BOARD_PX_PER_MM), round(down * _BOARD_PX_PER_MM))
    x, y = (width - across) / 2, (height - down + _RULER_MM) / 2
    page.imshow(
        board().generateImage(pixels),
        cmap='gray',
        extent=(x, x + across, y, y + down),
        interpolation='none',
    )
    page.set(xlim=(0, width), ylim=(0, height), aspect='auto')
