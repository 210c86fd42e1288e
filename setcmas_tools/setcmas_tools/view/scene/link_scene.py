"""Communication graph: lines between robots that hear each other, arrows for one way."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
import viser
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet import fleet
from setcmas_tools.view.model.communication import Pairs
from setcmas_tools.view.scene.tone import untoned

Points = NDArray[np.float32]
Colours = NDArray[np.uint8]
Handle = TypeVar('Handle', viser.LineSegmentsHandle, viser.ArrowsHandle)

_GREY = np.array([0.62, 0.66, 0.72])
_HEIGHT_M = 0.03
_WIDTH_M = 0.035
_GAP_M = 0.28  # between an arrow's tip and the robot, of a robot in its true size times 2


class LinkScene:
    """Draws the links between robots."""

    def __init__(self, scene: viser.SceneApi, root: str = '') -> None:
        """Prepare, in a frame; nothing is drawn yet."""
        self._scene, self._root = scene, root
        self._lines: viser.LineSegmentsHandle | None = None
        self._arrows: viser.ArrowsHandle | None = None

    def show(
        self, both: Pairs, one_way: Pairs, robots: list[int], poses: Floats, flashes: Floats
    ) -> None:
        """Draw the links.

        Args:
            both: Robot numbers of links that go both ways, shape (E, 2).
            one_way: Of links that go one way, sender first, shape (F, 2).
            robots: Numbers of the robots that are there.
            poses: Rows x, y in m and theta in rad, shape (3, N).
            flashes: From 0 to 1, how lately each one communicated, shape (N,).
        """
        both, one_way = _columns(both, robots), _columns(one_way, robots)
        points = np.column_stack([poses[0], poses[1], np.full(len(robots), _HEIGHT_M)])
        points = points.astype(np.float32)
        own = np.array([fleet.plot_colour(robot) for robot in robots]).reshape(-1, 3)
        lit = (255 * untoned(_GREY + flashes[:, None] * (own - _GREY))).astype(np.uint8)
        # The whole link takes the colour of the robot that has just sent over it.
        later = np.take_along_axis(both, flashes[both].argmax(axis=1)[:, None], axis=1)
        colours = np.repeat(lit[later], 2, axis=1)
        self._lines = _replaced(self._lines, points[both], colours, self._new_lines)
        ends = points[one_way]
        along = ends[:, 1] - ends[:, 0]
        length = np.linalg.norm(along, axis=1, keepdims=True)
        ends[:, 1] -= along * np.minimum(_GAP_M / np.maximum(length, 1e-6), 0.5)
        self._arrows = _replaced(self._arrows, ends, lit[one_way[:, 0]], self._new_arrows)

    def _new_lines(self, points: Points, colours: Colours) -> viser.LineSegmentsHandle:
        return self._scene.add_line_segments(
            f'{self._root}/links', points, colours, thickness=_WIDTH_M
        )

    def _new_arrows(self, points: Points, colours: Colours) -> viser.ArrowsHandle:
        return self._scene.add_arrows(
            f'{self._root}/one_way_links', points, colours,
            shaft_radius=0.012, head_radius=0.07, head_length=0.2,
        )  # fmt: skip


def _replaced(
    handle: Handle | None,
    points: Points,
    colours: Colours,
    new: Callable[[Points, Colours], Handle],
) -> Handle | None:
    """Return what shows links now: what did before, if they are as many."""
    if handle is not None and len(handle.points) == len(points):
        handle.points, handle.colors = points, colours
        return handle
    if handle is not None:
        handle.remove()
    return new(points, colours) if len(points) else None


def _columns(pairs: Pairs, robots: list[int]) -> Pairs:
    """Return the pairs whose robots are both there, as pairs of columns."""
    column = {robot: index for index, robot in enumerate(robots)}
    known = [(column[a], column[b]) for a, b in pairs.tolist() if a in column and b in column]
    return np.array(known, dtype=np.int64).reshape(-1, 2)
