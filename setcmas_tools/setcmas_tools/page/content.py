"""Content of a page: poses, calls of laws, drawings, links and charts of a run, as plain data."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function, ScriptFailure
from setcmas_tools.measures.agreement import disagreement, is_agreement
from setcmas_tools.measures.robot_metrics import SATURATION_TOLERANCE, largest_speed
from setcmas_tools.measures.safety_metrics import distances_of_pairs
from setcmas_tools.measures.task_errors import errors_of
from setcmas_tools.page.document import changes, colour_code, look_entry, page_content, rounded
from setcmas_tools.plots.reference_lines import draw_references, draws_references
from setcmas_tools.run.fleet_motion import LONGEST_GAP_S, SAME_TIME_S, Track
from setcmas_tools.run.run import Run, arena_of, models_of, obstacles_of
from setcmas_tools.run.run_records import MARKER, MOVING, Drawing, DrawnOverTime, FilteredCommands

if TYPE_CHECKING:
    from matplotlib.lines import Line2D

_STEPS_S = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0)
_MOST_POSES = 40_000
"""Of all robots; with more, the page would be too large for a mail."""
_MOST_DRAWINGS = 8_000
_COLUMNS = ('x', 'y', 'theta', 'v', 'omega')


def run_content(run: Run) -> dict[str, Any]:
    """Return all data of a page with a run."""
    t = common_times(run)
    return page_content(
        t=t.tolist(),
        robots=fleet_entry(run, t),
        calls=calls_entry(run),
        plane=plane_entry(run),
        charts=charts_entry(run, t),
    )


def common_times(run: Run) -> Floats:
    """Return the times in s of the poses on a page: multiples of a step."""
    begin, end = _begin_of(run), float(run.table.t[-1])
    for step in _STEPS_S:
        first = np.ceil(begin / step - SAME_TIME_S)
        last = np.floor(end / step + SAME_TIME_S)
        if (last - first) * len(run.robots) <= _MOST_POSES:
            break
    per_s = round(1 / step) if step < 1 else 1 / step  # 3/10, not 3 * 0.1
    times: Floats = np.arange(first, last + 1) / per_s + 0.0
    return times if len(times) else np.array([begin])


def _begin_of(run: Run) -> float:
    """Return when a page begins, in s: at the first command, or the first pose after it."""
    first, last = float(run.table.t[0]), float(run.table.t[-1])
    return max(first, 0.0) if last > 0.0 else first


def fleet_entry(run: Run, t: Floats) -> list[dict[str, Any]]:
    """Return the look and the motion of each robot at times in s."""
    models = models_of(run)
    entries = []
    for robot in run.robots:
        track = Track(run.table.of(robot))
        columns = zip(_COLUMNS, (*track.poses(t), *track.speeds(t)), strict=True)
        steps = enumerate(zip(t[:-1].tolist(), t[1:].tolist(), strict=True), 1)
        entry = {name: rounded(values) for name, values in columns}
        # Where a robot was moved, rather than drove.
        entry['breaks'] = [k for k, pair in steps if track.is_broken(*pair)]
        entries.append(look_entry(robot, models[robot], len(models)) | entry)
    return entries


_MOST_CALLS = 6_000
"""Of all robots; of longer runs the page has each second, fifth, ... call."""


def calls_entry(run: Run) -> dict[int, dict[str, Any]]:
    """Return the calls of each robot's law, by its number."""
    if run.commands is None:
        return {}
    begin, fastest = _begin_of(run) - SAME_TIME_S, _fastest(run)
    each = 1 + len(run.commands.t) // _MOST_CALLS
    entries = {}
    for robot in run.robots:
        own = run.commands.of(robot)
        rows = np.flatnonzero(own.t >= begin)[::each]
        if not len(rows):
            continue
        t, vx, vy = own.t[rows], own.vx[rows], own.vy[rows]
        overruled = np.full(len(t), '', dtype=object)
        entry = {'t': rounded(t), 'vx': rounded(vx), 'vy': rounded(vy)}
        if isinstance(own, FilteredCommands):
            overruled[own.changed[rows]] = 'The safety filter overruled it.'
            overruled[own.unsolved[rows]] = 'The safety filter stopped it: no velocity was safe.'
            entry['allowedX'] = rounded(own.allowed_vx[rows])
            entry['allowedY'] = rounded(own.allowed_vy[rows])
        outcomes = _outcomes(run, robot, t, overruled, np.hypot(vx, vy) >= fastest)
        entries[robot] = {**entry, 'words': changes(outcomes)}
    return entries


def _fastest(run: Run) -> float:
    """Return the speed in m/s from which a law is saturated; inf if it is unknown."""
    try:
        return largest_speed(run) * (1 - SATURATION_TOLERANCE)
    except SetcmasError:
        return math.inf


def _outcomes(
    run: Run, robot: int, t: Floats, overruled: NDArray[Any], saturated: NDArray[Any]
) -> list[tuple[str, str]]:
    """Return the outcome of each wanted velocity: a kind, for its colour, and a sentence."""
    found = []
    rows = zip(t.tolist(), states_at(run, robot, t), overruled, saturated, strict=True)
    for now, (state, held), by_filter, is_saturated in rows:
        outcome = '', ''
        if failure := failure_at(run, robot, now):
            place = f' in line {failure.line} of {failure.script}' if failure.line else ''
            outcome = 'failed', f'Its law failed{place}: {failure.first_line}'
        elif state != MOVING:
            outcome = 'stopped', f'The robot was {state} in the experiment.'
        elif by_filter or held:
            outcome = 'overruled', by_filter or 'A safety function overruled it.'
        elif is_saturated:
            outcome = 'saturated', 'The velocity is saturated at the speed limit.'
        found.append(outcome)
    return found


def states_at(run: Run, robot: int, t: Floats) -> list[tuple[str, bool]]:
    """Return a robot's state at times in s, and whether safety overruled its law.

    It moves where none is recorded, as in simulations.
    """
    record = run.safety
    if record is None:
        return [(MOVING, False)] * len(t)
    rows = np.flatnonzero(record.robot == robot)
    newest = np.searchsorted(record.t[rows], t + SAME_TIME_S, side='right') - 1
    return [
        (record.state[rows[k]], bool(record.overruled[rows[k]]))
        if k >= 0 and now - record.t[rows[k]] <= LONGEST_GAP_S
        else (MOVING, False)
        for k, now in zip(newest.tolist(), t.tolist(), strict=True)
    ]


def failure_at(run: Run, robot: int, t: float) -> ScriptFailure | None:
    """Return the failure of a robot's law at a time in s; None if it worked."""
    for one in reversed(run.info.failures or []):
        until = math.inf if one.until is None else one.until
        own = one.robot == robot and one.function is Function.CONTROL
        if own and one.t - SAME_TIME_S <= t < until - SAME_TIME_S:
            return one
    return None


def plane_entry(run: Run) -> dict[str, Any]:
    """Return references, arena, obstacles, drawings, links and broadcasts."""
    record = run.record
    obstacles = obstacles_of(run)
    return {
        'arena': arena_of(run),
        'discs': obstacles.discs,
        'polygons': [one.corners for one in obstacles.polygons],
        'references': _references(run),
        'drawings': _drawings(run),
        'links': None if record is None else np.round(record.changes, 4).tolist(),
        'sent': {
            robot: rounded(t) for robot, t in (record.trigger_times if record else {}).items()
        },
    }


def _references(run: Run) -> list[dict[str, Any]]:
    """Return the lines that the run's task draws into a film."""
    if not draws_references(run):  # then matplotlib may be missing
        return []
    from matplotlib.figure import Figure

    from setcmas_tools.plots.style import plot_style

    with plot_style():
        axes = Figure().add_subplot()
        draw_references(axes, run, is_film=True)
        return [_line(one) for one in axes.lines]


def _line(line: Line2D) -> dict[str, Any]:
    from matplotlib.colors import to_hex

    points: Floats = np.round(np.asarray(line.get_xydata(), dtype=float), 4)
    return {
        'points': points[np.isfinite(points).all(axis=1)].tolist(),
        'colour': to_hex(line.get_color()),
        'marked': line.get_marker() not in ('', ' ', 'None', None),
        'joined': line.get_linestyle() not in ('', ' ', 'None'),
    }


def _drawings(run: Run) -> list[dict[str, Any]]:
    """Return the drawings of scripts, a column for each marker and each trail."""
    columns: dict[tuple[int, str, str], list[Drawing]] = {}
    shown = DrawnOverTime(run.drawings).shown
    for one in shown:
        columns.setdefault((one.robot, one.name, one.kind), []).append(one)
    each = 1 + len(shown) // _MOST_DRAWINGS
    return [_column(drawn[::each], kind == MARKER) for (_, _, kind), drawn in columns.items()]


def _column(drawn: Sequence[Drawing], is_marker: bool) -> dict[str, Any]:
    spheres = [one.sphere for one in drawn]
    looks = [(round(s.diameter, 3), colour_code(s.colour), round(s.alpha, 3)) for s in spheres]
    return {
        'marker': is_marker,
        't': rounded([one.t for one in drawn]),
        'x': rounded([s.x for s in spheres]),
        'y': rounded([s.y for s in spheres]),
        'looks': changes(looks),
    }


FLEET = 0
"""The number under which a curve has the values of the whole fleet."""


def charts_entry(run: Run, t: Floats) -> list[dict[str, Any]]:
    """Return curves of a run at times in s, from its first command on, as in plots and metrics."""
    grid = run.counted_grid
    if not len(grid.t):  # nothing commanded these robots
        return []
    curves: list[tuple[str, str, Mapping[int, Floats]]] = []
    if len(grid.robots) > 1:
        if is_agreement(run):
            curves.append(('Disagreement', 'm', {FLEET: disagreement(grid.x, grid.y)}))
        curves.append(('Least separation', 'm', {FLEET: distances_of_pairs(grid)[0]}))
    speeds = {robot: Track(run[robot]).speeds(grid.t)[0] for robot in run.robots}
    curves.append(('Speed', 'm/s', speeds))
    if errors := errors_of(run):
        curves.append((errors.title, errors.unit, errors.values))
    return [
        {
            'name': name,
            'unit': unit,
            'values': {robot: rounded(_at(grid.t, own, t)) for robot, own in values.items()},
        }
        for name, unit, values in curves
    ]


def _at(known: Floats, values: Floats, t: Floats) -> Floats:
    """Return values at some of their own times, NaN at others."""
    places = np.clip(np.searchsorted(known, t - SAME_TIME_S), 0, len(known) - 1)
    return np.where(np.abs(known[places] - t) < SAME_TIME_S, values[places], np.nan)
