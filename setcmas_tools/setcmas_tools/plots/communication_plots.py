"""Plots of communication: graphs, times and counts of states sent."""

from __future__ import annotations

import math

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch
from matplotlib.ticker import MaxNLocator

from setcmas_simu.arrays import Floats
from setcmas_tools.plots.plot import applies_to
from setcmas_tools.plots.style import (
    drawn_robots,
    legend,
    line_handles,
    line_look,
    robot_handles,
    time_axis,
)
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_records import CommunicationRecord

MOST_ROBOTS = 60
"""Larger fleets have no graph, whose links would fill the plot, nor a histogram per robot."""

_MOST_GRAPHS = 6
_LARGEST_PT = 19.0
_PANELS_IN_ROW = 3
_EDGE = '0.4'
_HALF = 1.25  # half of a panel's side; robots are on a circle of radius 1


def _has_graph(run: Run) -> bool:
    has_changes = run.record is not None and len(run.record.changes) > 0
    return has_changes and 1 < len(run.robots) <= MOST_ROBOTS


@applies_to(_has_graph)
def draw_graph(figure: Figure, run: Run) -> None:
    """Draw the communication graphs: robots on a circle, arrows towards the receiver.

    One panel per graph of the run; of more than 6 graphs, an even selection.
    """
    assert run.record
    record, robots = run.record, run.robots
    graphs = _chosen(_graphs(record, max(robots[-1], int(record.changes[:, 1:3].max()))))
    columns = min(_PANELS_IN_ROW, len(graphs))
    rows = math.ceil(len(graphs) / columns)
    side = 6.0 if len(graphs) == 1 else 3.4
    figure.set_size_inches(side * columns, (side + 0.3) * rows + 0.3)
    panel = 72 * side  # in points
    diameter = min(_LARGEST_PT, panel * min(0.9 * math.pi / _HALF / len(robots), 0.15))
    host = figure.add_subplot()  # as wide as all panels, for the title
    host.set_axis_off()
    host.set_title('Communication graph')
    places = figure.add_gridspec(rows, columns)
    for k, (adjacency, caption) in enumerate(graphs):
        axes = figure.add_subplot(places[k // columns, k % columns])
        _draw_links(axes, adjacency, robots, diameter)
        _draw_robots(axes, robots, diameter)
        axes.set(xlabel=caption if len(graphs) > 1 else '', xticks=(), yticks=())
        axes.set(xlim=(-_HALF, _HALF), ylim=(-_HALF, _HALF), aspect='equal')
        axes.spines[:].set_visible(False)
    if any((adjacency != adjacency.T).any() for adjacency, _ in graphs):
        figure.supxlabel('arrows point to the receivers', fontsize='medium')


def _graphs(record: CommunicationRecord, nb_robots: int) -> list[tuple[Floats, str]]:
    """Return the different graphs of a run, each with its times."""
    found: dict[bytes, tuple[Floats, list[float]]] = {}
    adjacency = np.zeros((nb_robots, nb_robots))
    for t in np.unique(record.changes[:, 0]).tolist():
        for _, receiver, sender, weight in record.changes[record.changes[:, 0] == t]:
            adjacency[int(receiver) - 1, int(sender) - 1] = weight
        found.setdefault(adjacency.tobytes(), (adjacency.copy(), []))[1].append(t)
    return [(graph, _caption(times)) for graph, times in found.values()]


def _caption(times: list[float]) -> str:
    first = ', '.join(f'{t:.1f}'.removesuffix('.0') for t in times[:3])
    return f'from {first}{", …" if len(times) > 3 else ""} s on'


def _chosen(graphs: list[tuple[Floats, str]]) -> list[tuple[Floats, str]]:
    number = min(_MOST_GRAPHS, len(graphs))
    return [graphs[round(k)] for k in np.linspace(0, len(graphs) - 1, number).tolist()]


def _place(robot: int, robots: list[int]) -> tuple[float, float]:
    angle = math.tau * (0.25 - robots.index(robot) / len(robots))  # clockwise from the top
    return math.cos(angle), math.sin(angle)


def _draw_links(axes: Axes, adjacency: Floats, robots: list[int], diameter: float) -> None:
    heaviest = adjacency.max(initial=0.0) or 1.0
    for i, receiver in enumerate(robots):
        for j, sender in enumerate(robots):
            weight = adjacency[receiver - 1, sender - 1]
            both = weight == adjacency[sender - 1, receiver - 1]
            if not weight or (both and j < i):
                continue
            axes.add_patch(
                FancyArrowPatch(
                    _place(sender, robots),
                    _place(receiver, robots),
                    arrowstyle='-' if both else '-|>',
                    # Links with different weights in both directions must not overlap.
                    connectionstyle='arc3' if both else 'arc3,rad=0.12',
                    shrinkA=0.5 * diameter + 1.5,
                    shrinkB=0.5 * diameter + 1.5,
                    mutation_scale=0.7 * diameter,
                    linewidth=rcParams['lines.linewidth'] * (0.3 + 0.8 * weight / heaviest),
                    color=_EDGE,
                    zorder=1,
                )
            )


def _draw_robots(axes: Axes, robots: list[int], diameter: float) -> None:
    for robot in robots:
        colour = line_look(robot, len(robots))['color']
        red, green, blue = colour
        dark = 0.2126 * red + 0.7152 * green + 0.0722 * blue < 0.45
        x, y = _place(robot, robots)
        axes.plot(
            x, y, marker='o', markersize=diameter, markerfacecolor=colour, markeredgecolor='0.15',
            markeredgewidth=0.9, zorder=2,
        )  # fmt: skip
        axes.text(
            x, y, str(robot), ha='center', va='center_baseline', zorder=3,
            color='white' if dark else 'black',
            fontsize=min(rcParams['font.size'], 0.6 * diameter),
        )  # fmt: skip


_INCHES_PER_ROW = 0.6
_MOST_BINS = 60


def _is_event_triggered(run: Run) -> bool:
    return run.record is not None and run.record.is_event_triggered


@applies_to(_is_event_triggered)
def draw_instants(figure: Figure, run: Run) -> None:
    """Draw when each robot sent its state, in a row for each robot."""
    assert run.record
    table, record, robots = run.table, run.record, run.robots
    figure.set_size_inches(9.0, min(6.4, 1.6 + _INCHES_PER_ROW * len(robots)))
    axes = figure.add_subplot(title='Communication instants', ylabel='robot')
    drawn = drawn_robots(robots)
    looks = [line_look(robot, len(robots)) for robot in drawn]
    axes.eventplot(
        _sent(record, drawn),
        lineoffsets=drawn,
        linelengths=0.8 * len(robots) / len(drawn),
        linewidths=[look['linewidth'] for look in looks],
        colors=[look['color'] for look in looks],
    )
    for row, look in zip(axes.collections, looks, strict=True):
        row.set_path_effects(look.get('path_effects', []))
    axes.spines['left'].set_zorder(1)  # it would hide the first state, sent at t = 0
    axes.set_ylim(robots[-1] + 0.6, robots[0] - 0.6)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.grid(axis='y', visible=False)
    legend(axes, line_handles(robots) + time_axis([axes], table.t[0], table.t[-1]))


@applies_to(_is_event_triggered)
def draw_counts(figure: Figure, run: Run) -> None:
    """Draw the number of states sent over time, compared with periodic communication.

    Top: the whole fleet; bottom: each robot. Periodic means one state per evaluation.
    """
    assert run.record
    table, record, robots = run.table, run.record, run.robots
    figure.set_size_inches(9.0, 6.4)
    panels = list(figure.subplots(2, sharex=True))
    end = table.t[-1]
    evaluated, sent = record.triggers[:, 0], record.triggers[record.triggers[:, 2] == 1, 0]
    grey = {'color': '0.45', 'linestyle': '--'}
    (periodic,) = panels[0].plot(*_steps(evaluated, end), **grey, label='periodic')
    share = f'{len(sent):,} of {len(evaluated):,} ({100 * len(sent) / len(evaluated):.1f} %)'
    (triggered,) = panels[0].plot(
        *_steps(sent, end), color='0.1', label=f'event-triggered\n{share}'
    )
    panels[0].set(ylabel='states sent, fleet')
    drawn = drawn_robots(robots)
    for robot, times in zip(drawn, _sent(record, drawn), strict=True):
        panels[1].plot(*_steps(times, end), **line_look(robot, len(robots)))
    panels[1].set(ylabel='states sent, each robot')
    panels[0].set_title('Communications')
    for axes in panels:
        axes.set_ylim(bottom=0.0)
    marks = time_axis(panels, table.t[0], end)
    legend(panels[0], [periodic, triggered, *marks])
    legend(panels[1], line_handles(robots))
    figure.align_ylabels()


@applies_to(_is_event_triggered)
def draw_intervals(figure: Figure, run: Run) -> None:
    """Draw how often each time between two states of a robot occurred, and the least of them."""
    assert run.record
    intervals, robots = run.record.intervals, run.robots
    figure.set_size_inches(9.0, 4.6)
    axes = figure.add_subplot(title='Inter-event times', ylabel='states sent')
    axes.set_xlabel('time since the robot sent its state before (s)')
    known = np.concatenate([np.empty(0), *intervals.values()])
    if not len(known):
        return
    # Bins are centred on multiples of the time between two evaluations, which intervals are.
    t, of_robots, _ = run.record.triggers.T
    step = float(np.median(np.diff(t[of_robots == of_robots[0]])))
    width = step * max(1, math.ceil((known.max() / step + 1) / _MOST_BINS))
    edges = np.arange(0.5 * step, known.max() + width + step, width)
    own = [intervals.get(robot, np.empty(0)) for robot in robots]
    is_small = len(robots) <= MOST_ROBOTS
    axes.hist(
        own if is_small else known,
        edges.tolist(),
        stacked=True,
        color=[line_look(robot, len(robots))['color'] for robot in robots] if is_small else '0.6',
        edgecolor='0.25',
        linewidth=0.4,
    )
    label = f'least: {known.min():.2f} s'
    least = axes.axvline(known.min(), color='0.1', linestyle='--', label=label)
    axes.set_xlim(left=0.0)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    legend(axes, [*(robot_handles(robots) if is_small else []), least])


def _sent(record: CommunicationRecord, robots: list[int]) -> list[Floats]:
    times = record.trigger_times
    return [times.get(robot, np.empty(0)) for robot in robots]


def _steps(t: Floats, end: float) -> tuple[Floats, Floats]:
    """Return the points of a line that steps up by one at each time."""
    t = np.sort(t)
    counts = np.arange(len(t) + 1, dtype=float)
    times = np.array([min([end, *t[:1]]), *t, max([end, *t[-1:]])])
    return np.repeat(times, 2)[1:-1], np.repeat(counts, 2)
