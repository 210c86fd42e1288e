"""Symbols of robots in plots and films: the outlines of their models, all about as large."""

from __future__ import annotations

import numpy as np
from matplotlib.path import Path as Outline

from setcmas_simu.arrays import Floats
from setcmas_simu.robots.models import shape_of
from setcmas_tools.run.arena import models_of
from setcmas_tools.run.run import Run

_SIDE = 1.587
"""Side of the square that is as large as the rectangle around a symbol."""


def symbols(run: Run) -> dict[int, Floats]:
    """Return the outline of each robot, heading along the x axis, shape (K, 2)."""
    return {robot: symbol(model) for robot, model in models_of(run).items()}


def symbol(model: str) -> Floats:
    """Return the outline of a model, as `symbols` does."""
    corners = np.array(shape_of(model).outline)
    scaled: Floats = corners * (_SIDE / np.sqrt(np.prod(np.ptp(corners, axis=0))))
    return scaled


def closed(corners: Floats) -> Outline:
    """Return an outline as a path."""
    return Outline(np.vstack([corners, corners[:1]]), closed=True)
