"""Trails behind the robots; only the newest chunk is sent again and again."""

from __future__ import annotations

import itertools

import numpy as np
import viser

from setcmas_simu.fleet import fleet
from setcmas_tools.view.model.trails import Chunk, Trails
from setcmas_tools.view.scene.tone import untoned

_WIDTH_M = 0.02  # of a robot in its true size


class TrailScene:
    """Draws the chunks of the trails.

    Attributes:
        width: Of the lines that come, as a share of the usual one.
    """

    def __init__(self, scene: viser.SceneApi, root: str = '') -> None:
        """Prepare, in a frame; nothing is drawn yet."""
        self._scene, self._root = scene, root
        self.width = 1.0
        self._handles: dict[int, viser.LineSegmentsHandle] = {}
        self._finished: set[int] = set()

    def show(self, trails: Trails, size: float) -> None:
        """Draw the trails as they are now, for robots that are so many times too large."""
        for number in self._handles.keys() - {chunk.number for chunk in trails.chunks}:
            self._handles.pop(number).remove()
            self._finished.discard(number)
        for chunk in trails.chunks:
            if chunk.number not in self._finished:
                self._draw(chunk, size)
                if chunk is not trails.chunks[-1]:
                    self._finished.add(chunk.number)

    def _draw(self, chunk: Chunk, size: float) -> None:
        points = chunk.points.reshape(-1, 2, 3)
        handle = self._handles.get(chunk.number)
        if handle is not None:
            handle.points = points
            return
        # The colours of plots: a white trail could not be seen on the ground.
        colours = untoned([fleet.plot_colour(robot) for robot in chunk.robots])
        per_point = np.repeat(colours, chunk.points.shape[1], axis=0)[:, None].repeat(2, axis=1)
        self._handles[chunk.number] = self._scene.add_line_segments(
            self._free_name(), points, per_point, thickness=self.width * size * _WIDTH_M
        )

    def _free_name(self) -> str:
        """Return a name that no chunk has now: viser remembers every name that it has seen."""
        taken = {handle.name for handle in self._handles.values()}
        names = (f'{self._root}/trails/{number}' for number in itertools.count())
        return next(name for name in names if name not in taken)
