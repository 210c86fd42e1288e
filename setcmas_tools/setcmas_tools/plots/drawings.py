"""Drawings of control scripts in plots and films of the plane."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.lines import Line2D

from setcmas_ctrl.drawing import Sphere
from setcmas_tools.records.drawings import MARKER, Drawing
from setcmas_tools.run.run import Run

_ANGLES = np.linspace(0.0, 2 * np.pi, 32, endpoint=False)
_CIRCLE = 0.5 * np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])


class DrawnPlane:
    """What the scripts of a run drew, as discs in a plane.

    Attributes:
        handles: What to put in the legend.
        markers: The artist of what takes the place of what was drawn before.
        trails: The artist of what stays.
    """

    def __init__(self, axes: Axes, run: Run) -> None:
        """Let the plane show all that was drawn at some time; nothing is seen before `show`."""
        self._drawings = [d for d in run.drawings if np.isfinite(np.hstack(d.sphere)).all()]
        self.trails = PolyCollection([], linewidths=0, zorder=1.8)
        self.markers = PolyCollection([], linewidths=0, zorder=2.5)
        for artist in (self.trails, self.markers):
            axes.add_collection(artist, autolim=False)
        self.handles = [_handle(self._drawings[-1].sphere)] if self._drawings else []
        if self._drawings:
            axes.update_datalim([(d.sphere.x, d.sphere.y) for d in self._drawings])

    def show(self, t: float, since: float = -np.inf) -> None:
        """Show the markers of a time in s, and the trails that have grown since another one."""
        markers: dict[tuple[int, str], Sphere] = {}
        trails = []
        for drawing in self._until(t):
            if drawing.kind == MARKER:
                markers[drawing.robot, drawing.name] = drawing.sphere
            elif drawing.t > since:
                trails.append(drawing.sphere)
        _fill(self.markers, list(markers.values()))
        _fill(self.trails, trails)

    def _until(self, t: float) -> Iterator[Drawing]:
        return (drawing for drawing in self._drawings if drawing.t <= t)


def _fill(artist: PolyCollection, spheres: Sequence[Sphere]) -> None:
    artist.set_verts([(s.x, s.y) + s.diameter * _CIRCLE for s in spheres])
    artist.set_facecolor([_shown(*s.colour, s.alpha) for s in spheres])


def _handle(sphere: Sphere) -> Line2D:
    look: dict[str, Any] = {'linestyle': '', 'marker': 'o', 'markeredgewidth': 0}
    return Line2D([], [], label='drawn by the script', color=_shown(*sphere.colour, 1.0), **look)


def _shown(*colour: float) -> tuple[float, float, float, float]:
    """Return a colour that a script gave, with each part from 0 to 1."""
    red, green, blue, alpha = np.clip(colour, 0.0, 1.0).tolist()
    return red, green, blue, alpha
