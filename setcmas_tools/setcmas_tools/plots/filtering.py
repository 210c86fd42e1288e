"""Plot of what control laws wanted and what the safety filter allowed."""

from __future__ import annotations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from setcmas_ctrl.filter.verdict import Verdict
from setcmas_tools.kinds.plot import applies_to
from setcmas_tools.plots.looks.style import legend, line_look, robot_handles, time_axis
from setcmas_tools.records.commands import Commands
from setcmas_tools.run.run import Run

_LOOKS = {
    Verdict.CHANGED: ('changed', '0.75'),
    Verdict.BLOCKED: ('blocked', '0.2'),
    Verdict.NO_SOLUTION: ('no solution', '#d62728'),
}
_BAR = 0.7


@applies_to(lambda run: run.commands is not None and run.commands.allowed is not None)
def draw_filter(figure: Figure, run: Run) -> None:
    """Draw the speeds that were wanted and allowed, and when the filter changed them."""
    figure.set_size_inches(9.0, 6.4)
    commands = run.commands
    assert commands
    speeds, verdicts = figure.subplots(2, sharex=True)
    for robot in run.robots:
        own = commands.of(robot)
        _draw_speeds(speeds, own, robot, len(run.robots))
        _draw_verdicts(verdicts, own, robot)
    speeds.set_title('Wanted and allowed speed')
    speeds.set_ylabel('speed (m/s)')
    speeds.set_ylim(bottom=0.0)
    verdicts.set_ylabel('robot')
    verdicts.set_ylim(run.robots[-1] + 0.6, run.robots[0] - 0.6)
    if len(run.robots) <= 12:
        verdicts.set_yticks(run.robots)
    marks = time_axis([speeds, verdicts], run.table.t[0], run.table.t[-1])
    ways: list[Artist] = [
        Line2D([], [], label='wanted', color='0.4', linestyle=':'),
        Line2D([], [], label='allowed', color='0.4'),
    ]
    legend(speeds, [*robot_handles(run.robots), *ways, *marks])
    legend(verdicts, [Patch(label=name, color=colour) for name, colour in _LOOKS.values()])
    figure.align_ylabels()


def _draw_speeds(axes: Axes, commands: Commands, robot: int, nb_robots: int) -> None:
    allowed = commands.allowed
    assert allowed
    look = line_look(robot, nb_robots)
    wanted = np.hypot(commands.vx, commands.vy)
    axes.plot(commands.t, wanted, **{**look, 'linestyle': ':', 'path_effects': None})
    axes.plot(commands.t, np.hypot(allowed.vx, allowed.vy), **look)


def _draw_verdicts(axes: Axes, commands: Commands, robot: int) -> None:
    """Draw a bar over the times of each verdict."""
    assert commands.allowed
    ends = np.append(commands.t[1:], commands.t[-1:])
    for verdict, (_, colour) in _LOOKS.items():
        held = commands.allowed.verdict == verdict
        bars = list(zip(commands.t[held], (ends - commands.t)[held], strict=True))
        axes.broken_barh(bars, (robot - 0.5 * _BAR, _BAR), color=colour, linewidth=0)
