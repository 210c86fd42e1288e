"""Plots of event-triggered broadcast: instants and counts of the states sent."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from setcmas_simu.arrays import Floats
from setcmas_tools.kinds.plot import applies_to
from setcmas_tools.plots.looks.style import legend, line_look, robot_handles, time_axis
from setcmas_tools.records.communication import CommunicationRecord
from setcmas_tools.records.fleet_table import FleetTable
from setcmas_tools.run.run import Run

_MOST_PANELS = 12
_INCHES_PER_PANEL = 0.78


def _is_event_triggered(run: Run) -> bool:
    return run.record is not None and run.record.is_event_triggered


@applies_to(_is_event_triggered)
def draw_instants(figure: Figure, run: Run) -> None:
    """Draw when each robot sent its state: a panel per robot, a row per robot of larger fleets.

    As in figure 4 of Bertrand, ECC 2024.
    """
    assert run.record
    table, record, robots = run.table, run.record, run.robots
    if len(robots) > _MOST_PANELS:
        _draw_rows(figure, table, record)
        return
    figure.set_size_inches(9.0, 1.2 + _INCHES_PER_PANEL * len(robots))
    panels = np.atleast_1d(figure.subplots(len(robots), sharex=True)).tolist()
    for axes, robot in zip(panels, robots, strict=True):
        times, _ = _sent_and_evaluated(record, robot)
        axes.plot(*_spikes(times, 0.0, 1.0), **line_look(robot, len(robots)))
        axes.spines['left'].set_zorder(1)  # it would hide the first state, sent at t = 0
        axes.set(ylim=(0.0, 1.25), yticks=(0, 1))
        axes.set_ylabel(f'robot {robot}', rotation=0, ha='right', va='center')
        axes.grid(axis='y', visible=False)
    panels[0].set_title('Communication instants (1: state sent)')
    if marks := time_axis(panels, table.t[0], table.t[-1]):
        legend(panels[0], marks)


def _draw_rows(figure: Figure, table: FleetTable, record: CommunicationRecord) -> None:
    figure.set_size_inches(9.0, 6.4)
    axes = figure.add_subplot(title='Communication instants', ylabel='robot')
    robots = table.robots
    for robot in robots:
        times, _ = _sent_and_evaluated(record, robot)
        axes.plot(*_spikes(times, robot - 0.4, robot + 0.4), **line_look(robot, len(robots)))
    axes.spines['left'].set_zorder(1)
    axes.set_ylim(robots[-1] + 0.6, robots[0] - 0.6)
    axes.grid(axis='y', visible=False)
    legend(axes, robot_handles(robots) + time_axis([axes], table.t[0], table.t[-1]))


@applies_to(_is_event_triggered)
def draw_counts(figure: Figure, run: Run) -> None:
    """Draw how many states were sent over time, against periodic communication.

    Above of the whole fleet, below of each robot; periodic is a state at each evaluation.
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
    for robot in robots:
        times, _ = _sent_and_evaluated(record, robot)
        panels[1].plot(*_steps(times, end), **line_look(robot, len(robots)))
    panels[1].set(ylabel='states sent, each robot')
    panels[0].set_title('Communications')
    for axes in panels:
        axes.set_ylim(bottom=0.0)
    marks = time_axis(panels, table.t[0], end)
    legend(panels[0], [periodic, triggered, *marks])
    legend(panels[1], robot_handles(robots))
    figure.align_ylabels()


def _sent_and_evaluated(record: CommunicationRecord, robot: int) -> tuple[Floats, Floats]:
    rows = record.triggers[record.triggers[:, 1] == robot]
    return rows[rows[:, 2] == 1, 0], rows[:, 0]


def _spikes(t: Floats, low: float, high: float) -> tuple[Floats, Floats]:
    """Return the points of a line that goes up and down at each time, with gaps between."""
    return np.repeat(t, 3), np.tile([low, high, np.nan], len(t))


def _steps(t: Floats, end: float) -> tuple[Floats, Floats]:
    """Return the points of a line that goes up by one at each time."""
    t = np.sort(t)
    counts = np.arange(len(t) + 1, dtype=float)
    times = np.array([min([end, *t[:1]]), *t, max([end, *t[-1:]])])
    return np.repeat(times, 2)[1:-1], np.repeat(counts, 2)
