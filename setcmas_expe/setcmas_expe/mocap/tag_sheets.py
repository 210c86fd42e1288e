"""Sheets to print: tags of robots and of the floor, a board for the lens, and a ruler on each."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from setcmas_expe.mocap.camera_file import FIRST_FLOOR_TAG
from setcmas_expe.mocap.camera_poses import Picture, tag_family
from setcmas_simu.errors import file_errors, needs
from setcmas_simu.limited_file import written_whole

with needs('camera'):
    import cv2

PAPERS = {'a4': (210.0, 297.0), 'letter': (215.9, 279.4)}
"""Width and height in mm."""
SMALLEST_MM = 20.0
BOARD = (5, 7)
"""Squares across and down the ChArUco board."""

_SQUARE_MM, _MARKER_MM = 33.0, 25.0
_MARGIN = 1 / 8
"""White margin of a tag, one of its modules, relative to its size."""
_EDGE_MM = 10.0
"""Edge of the paper on which printers do not print."""
_RULER_MM = 20.0
"""Height of the ruler at the bottom of each page."""
_STRIP_MM = 12.0
"""Height of the strip with number and arrow, in front of the tag."""
_PX_PER_MM, _TAG_PX = 8, 800


def largest_size(paper: str) -> float:
    """Return the largest size in mm of a tag that fits a paper."""
    width, height = PAPERS[paper]
    free = min(width - 2 * _EDGE_MM, height - 2 * _EDGE_MM - _RULER_MM - _STRIP_MM)
    return float(np.floor(free / (1 + 2 * _MARGIN)))


def write_sheets(path: Path, pages: Iterator[Figure]) -> int:
    """Write a PDF file, whole or not at all; return the number of pages, or raise SetcmasError."""
    with (
        file_errors(f"'{path}' cannot be written"),
        written_whole(path) as file,
        PdfPages(file.buffer) as pdf,
    ):
        for page in pages:
            pdf.savefig(page)
        count: int = pdf.get_pagecount()
    return count


def sheets(nb_robots: int, nb_floor_tags: int, size: float, paper: str) -> Iterator[Figure]:
    """Yield pages: tags of the robots 1 to N and of the floor, `size` in mm, and the board."""
    width, height = PAPERS[paper]
    across = size * (1 + 2 * _MARGIN)
    x, y = (width - across) / 2, height - _EDGE_MM - _STRIP_MM - across
    robots = range(1, nb_robots + 1)
    for tag in (*robots, *range(FIRST_FLOOR_TAG, FIRST_FLOOR_TAG + nb_floor_tags)):
        figure, page = _page(paper)
        _draw_tag(page, x, y, size, tag)
        yield figure
    figure, page = _page(paper)
    across, down = np.array(BOARD) * _SQUARE_MM
    x, y = (width - across) / 2, (height - down + _RULER_MM) / 2
    pixels = (round(across * _PX_PER_MM), round(down * _PX_PER_MM))
    _draw(page, board().generateImage(pixels), x, y, float(across))
    yield figure


def board() -> cv2.aruco.CharucoBoard:
    """Return the ChArUco board of the sheets, with lengths in m."""
    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    return cv2.aruco.CharucoBoard(BOARD, _SQUARE_MM / 1e3, _MARKER_MM / 1e3, family)


def _page(paper: str) -> tuple[Figure, Axes]:
    """Return a page whose axes are in mm, with the ruler."""
    width, height = PAPERS[paper]
    figure = Figure(figsize=(width / 25.4, height / 25.4))
    page = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    page.set(xlim=(0, width), ylim=(0, height))
    page.set_axis_off()
    left, y = (width - 100) / 2, _EDGE_MM + 10
    page.plot([left, left + 100], [y, y], 'k', linewidth=0.5)
    for x in range(0, 101, 10):
        page.plot([left + x] * 2, [y, y + (4 if x % 50 == 0 else 2.5)], 'k', linewidth=0.5)
    text = 'print at 100 %: this ruler must be 100 mm long'
    page.text(width / 2, y - 3, text, ha='center', va='top', fontsize=8)
    return figure, page


def _draw_tag(page: Axes, x: float, y: float, size: float, tag: int) -> None:
    """Draw a tag with the line to cut along; its lower left corner is x, y in mm."""
    across = size * (1 + 2 * _MARGIN)
    left, right, top = x, x + across, y + across + _STRIP_MM
    page.plot([left, right, right, left, left], [y, y, top, top, y], '0.7', linewidth=0.4)
    pixels = tag_family().generateImageMarker(tag, _TAG_PX)
    _draw(page, pixels, x + _MARGIN * size, y + _MARGIN * size, size)
    middle, is_floor = y + across + _STRIP_MM / 2, tag >= FIRST_FLOOR_TAG
    name, size_pt = 'floor' if is_floor else 'robot', 9 if size >= 40 else 6
    page.text(x + 2, middle, f'{name} {tag}', va='center', fontsize=size_pt)
    if not is_floor:
        low, tip, half = y + across + 1, y + across + _STRIP_MM - 1.5, 0.05 * size
        page.fill(x + across / 2 + np.array([-half, half, 0]), [low, low, tip], color='black')
        page.text(x + across - 2, middle, 'front', ha='right', va='center', fontsize=size_pt)


def _draw(page: Axes, pixels: Picture, x: float, y: float, width: float) -> None:
    """Draw a picture; the page has limits, so that it keeps its axes."""
    rows, columns = pixels.shape
    extent = (x, x + width, y, y + width * rows / columns)
    page.imshow(pixels, cmap='gray', extent=extent, interpolation='none', aspect='auto')
