"""Curves for the charts of the page, at the times of its poses."""

from __future__ import annotations

from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_tools.replay.curves import Curve, curves, difference
from setcmas_tools.report.packing import packed
from setcmas_tools.run.fleet_motion import SAME_TIME_S
from setcmas_tools.run.run import Run


def charts_entry(run: Run, other: Run | None, t: Floats) -> list[dict[str, Any]]:
    """Return what the charts show: curves of a run, those of another one, their difference."""
    theirs = {one.name: one for one in curves(other)} if other else {}
    entries = []
    for curve in curves(run):
        entry = _entry(curve, t)
        if curve.name in theirs:
            entry['other'] = _entry(theirs[curve.name], t)['values']
        entries.append(entry)
    apart = difference(run, other) if other else None
    return [_entry(apart, t), *entries] if apart else entries


def _entry(curve: Curve, t: Floats) -> dict[str, Any]:
    values = {robot: packed(_at(curve.t, own, t)) for robot, own in curve.values.items()}
    return {'name': curve.name, 'unit': curve.unit, 'values': values}


def _at(known: Floats, values: Floats, t: Floats) -> Floats:
    """Return values at some of their own times, NaN at others."""
    if not len(known):
        return np.full(len(t), np.nan)
    places = np.clip(np.searchsorted(known, t - SAME_TIME_S), 0, len(known) - 1)
    return np.where(np.abs(known[places] - t) < SAME_TIME_S, values[places], np.nan)
