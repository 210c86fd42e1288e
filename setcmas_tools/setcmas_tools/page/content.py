"""Content of a page: poses, calls of laws, drawings, links and charts of a run, as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from setcmas_ctrl.filter.safety_filter import Verdict
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.page.facts import first_line
from setcmas_tools.page.instant import (
    Curve,
    Instants,
    RobotInstant,
    curves,
    difference,
)
from setcmas_tools.page.looks import changes, colour_code, look_entry, packed, page_content
from setcmas_tools.page.run_history import RunHistory
from setcmas_tools.plots.style import plot_style
from setcmas_tools.plots.trajectories import draw_references
from setcmas_tools.run.fleet_motion import SAME_TIME_S
from setcmas_tools.run.law_output import MARKER, MOVING, Drawing, DrawnOverTime
from setcmas_tools.run.run import Run, arena_of, models_of, obstacles_of

_STEPS_S = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0)
_MOST_POSES = 100_000
"""Of all robots; with more, the page would be too large for a mail."""
_MOST_DRAWINGS = 8_000
_MOST_CALLS = 6_000
"""Of all robots; of longer runs the page has each second, fifth, ... call."""
_MOST_KNOWN = 300_000
"""Positions that robots knew of each other; with more, the page would be too large for a mail."""
_TOO_MUCH = 'not on this page, because the run is too long'
_OVERRULED = {
    Verdict.CHANGED: 'The safety filter overruled it.',
    Verdict.BLOCKED: 'The safety filter overruled it: robots block each other.',
    Verdict.NO_SOLUTION: 'The safety filter stopped it: no velocity was safe.',
}


def run_content(run: Run, other: Run | None = None) -> dict[str, Any]:
    """Return everything that the page draws of a run, and of another one over it."""
    history = RunHistory(run)
    t = common_times(history)
    return page_content(
        t=t.tolist(),
        robots=fleet_entry(history, t),
        others=fleet_entry(RunHistory(other), t) if other else [],
        calls=calls_entry(history),
        plane=plane_entry(history),
        charts=charts_entry(run, other, t),
    )


def common_times(history: RunHistory) -> Floats:
    """Return the times in s of the poses on a page: multiples of a step."""
    for step in _STEPS_S:
        first = np.ceil(history.t0 / step - SAME_TIME_S)
        last = np.floor(history.t1 / step + SAME_TIME_S)
        if (last - first) * len(history.robots) <= _MOST_POSES:
            break
    per_s = round(1 / step) if step < 1 else 1 / step  # 3/10, not 3 * 0.1
    times: Floats = np.arange(first, last + 1) / per_s + 0.0
    return times if len(times) else np.array([history.t0])


def fleet_entry(history: RunHistory, t: Floats) -> list[dict[str, Any]]:
    """Return the look and the motion of each robot at times in s."""
    x, y, theta = history.poses_at(t)
    speeds = history.speeds_at(t)
    models = models_of(history.run)
    put = [history.put(*pair) for pair in zip(t[:-1].tolist(), t[1:].tolist(), strict=True)]
    return [
        {
            **look_entry(robot, models[robot], len(models)),
            'x': packed(x[:, column]),
            'y': packed(y[:, column]),
            'theta': packed(theta[:, column]),
            'v': packed(speeds[0, :, column]),
            'omega': packed(speeds[1, :, column]),
            'breaks': [k for k, robots in enumerate(put, 1) if robot in robots],
        }
        for column, robot in enumerate(history.robots)
    ]


def plane_entry(history: RunHistory) -> dict[str, Any]:
    """Return references, arena, obstacles, drawings, links and broadcasts."""
    run = history.run
    record = run.record
    obstacles = obstacles_of(run)
    return {
        'arena': arena_of(run),
        'discs': obstacles.discs,
        'polygons': [one.corners for one in obstacles.polygons],
        'references': _references(run),
        'drawings': _drawings(history),
        'links': None if record is None else np.round(record.changes, 4).tolist(),
        'sent': {
            robot: packed(t) for robot, t in (record.trigger_times if record else {}).items()
        },
    }


def _references(run: Run) -> list[dict[str, Any]]:
    """Return the lines that the run's task draws into a film."""
    axes: Axes = Figure().add_subplot()
    with plot_style():
        draw_references('film', axes, run)
    return [_line(one) for one in axes.lines]


def _line(line: Line2D) -> dict[str, Any]:
    points: Floats = np.round(np.asarray(line.get_xydata(), dtype=float), 4)
    return {
        'points': points[np.isfinite(points).all(axis=1)].tolist(),
        'colour': to_hex(line.get_color()),
        'marked': line.get_marker() not in ('', ' ', 'None', None),
        'joined': line.get_linestyle() not in ('', ' ', 'None'),
    }


def _drawings(history: RunHistory) -> list[dict[str, Any]]:
    """Return the drawings of scripts, a column for each marker and each trail."""
    columns: dict[tuple[int, str, str], list[Drawing]] = {}
    shown = DrawnOverTime(history.run.drawings).shown
    for one in shown:
        columns.setdefault((one.robot, one.name, one.kind), []).append(one)
    each = 1 + len(shown) // _MOST_DRAWINGS
    return [_column(drawn[::each], kind == MARKER) for (_, _, kind), drawn in columns.items()]


def _column(drawn: Sequence[Drawing], is_marker: bool) -> dict[str, Any]:
    spheres = [one.sphere for one in drawn]
    looks = [(round(s.diameter, 3), colour_code(s.colour), round(s.alpha, 3)) for s in spheres]
    return {
        'marker': is_marker,
        't': packed([one.t for one in drawn]),
        'x': packed([s.x for s in spheres]),
        'y': packed([s.y for s in spheres]),
        'looks': changes(looks),
    }


def calls_entry(history: RunHistory) -> dict[int, dict[str, Any]]:
    """Return the calls of each robot's law, by its number."""
    commands, failures = history.run.commands, history.run.info.failures or []
    instants = Instants(history)
    each = 1 + len(commands.t) // _MOST_CALLS if commands else 1
    entries = {}
    for robot in history.robots:
        failed = np.array([one.t for one in failures if one.robot == robot])
        t = commands.of(robot).t if commands else failed
        t = t[t >= history.t0 - SAME_TIME_S][::each]
        if len(t):
            entries[robot] = _calls(history, [instants.of(robot, now) for now in t.tolist()])
    return entries


def _calls(history: RunHistory, calls: list[RobotInstant]) -> dict[str, Any]:
    wanted = np.array([one.wanted or (np.nan, np.nan) for one in calls])
    entry: dict[str, Any] = {
        't': packed([one.t for one in calls]),
        'vx': packed(wanted[:, 0]),
        'vy': packed(wanted[:, 1]),
        'words': changes([state_in_words(one) for one in calls]),
    }
    if any(one.allowed for one in calls):
        allowed = np.array([one.allowed or (np.nan, np.nan) for one in calls])
        entry |= {'allowedX': packed(allowed[:, 0]), 'allowedY': packed(allowed[:, 1])}
    return entry | _known(history, calls)


def state_in_words(one: RobotInstant) -> tuple[str, str]:
    """Return what became of the velocity that a law wanted: a kind for the colour, and a text."""
    if one.failure:
        place = f' in line {one.failure.line} of {one.failure.script}' if one.failure.line else ''
        return 'failed', f'Its law failed{place}: {first_line(one.failure)}'
    if one.state not in (None, MOVING):
        return 'stopped', f'The experiment had it {one.state}.'
    if one.overruled:
        return 'overruled', _OVERRULED.get(one.verdict or Verdict.KEPT, 'Safety overruled it.')
    return ('saturated', 'That is the largest speed: saturated.') if one.saturated else ('', '')


def _known(history: RunHistory, calls: list[RobotInstant]) -> dict[str, Any]:
    """Return the poses of the others that a robot knew, unless it knew all."""
    if history.run.record is None:
        return {}
    reason = next((one.unknown for one in calls if one.known is None), '')
    if reason:
        return {'unknown': reason}
    known: Floats = np.array([one.known for one in calls])
    if known.size * len(history.robots) > _MOST_KNOWN:
        return {'unknown': _TOO_MUCH}
    return {
        'known': [
            {
                'name': robot_name(sender + 1),
                'number': sender + 1,
                'x': packed(known[:, 0, sender]),
                'y': packed(known[:, 1, sender]),
            }
            for sender in range(known.shape[2])
            if sender + 1 != calls[0].robot and np.isfinite(known[:, 0, sender]).any()
        ]
    }


def charts_entry(run: Run, other: Run | None, t: Floats) -> list[dict[str, Any]]:
    """Return the curves of a run, those of another one, and their difference."""
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
