"""Drawings of control scripts in plots and films of the plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.lines import Line2D

from setcmas_ctrl.drawing import Sphere
from setcmas_tools.records.drawings import Drawing, DrawnOverTime
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
        self._drawn = DrawnOverTime(run.drawings)
        self.trails = PolyCollection([], linewidths=0, zorder=1.8)
        self.markers = PolyCollection([], linewidths=0, zorder=2.5)
        for artist in (self.trails, self.markers):
            axes.add_collection(artist, autolim=False)
        self.handles = [_handle(self._drawn.shown[-1].sphere)] if self._drawn.shown else []
        if self._drawn.shown:
            axes.update_datalim([(d.sphere.x, d.sphere.y) for d in self._drawn.shown])

    def show(self, t: float, since: float = -np.inf) -> None:
        """Show the markers of a time in s, and the trails that have grown since another one."""
        _fill(self.markers, self._drawn.markers(t))
        _fill(self.trails, self._drawn.trails(t, since))


def _fill(artist: PolyCollection, drawings: Sequence[Drawing]) -> None:
    spheres = [drawing.sphere for drawing in drawings]
    artist.set_verts([(s.x, s.y) + s.diameter * _CIRCLE for s in spheres])
    artist.set_facecolor([_shown(*s.colour, s.alpha) for s in spheres])


def _handle(sphere: Sphere) -> Line2D:
    look: dict[str, Any] = {'linestyle': '', 'marker': 'o', 'markeredgewidth': 0}
    return Line2D([], [], label='drawn by the script', color=_shown(*sphere.colour, 1.0), **look)


def _shown(*colour: float) -> tuple[float, float, float, float]:
    """Return a colour that a script gave, with each part from 0 to 1."""
    red, green, blue, alpha = np.clip(colour, 0.0, 1.0).tolist()
    return red, green, blue, alpha
