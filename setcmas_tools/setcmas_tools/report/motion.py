"""Motion of a fleet for the page: poses and speeds at common times, looks of robots."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import to_hex

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.fleet import plot_colour
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.plots.style import edge_effects
from setcmas_tools.plots.trajectories import symbols
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.report.packing import packed
from setcmas_tools.run.fleet_motion import SAME_TIME_S

_STEPS_S = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0)
_MOST_POSES = 100_000
"""Of all robots; a page of more of them would be too large for a mail."""


def common_times(history: RunHistory) -> Floats:
    """Return times in s at which a page tells where the robots are: multiples of a step."""
    for step in _STEPS_S:
        first = np.ceil(history.t0 / step - SAME_TIME_S)
        last = np.floor(history.t1 / step + SAME_TIME_S)
        if (last - first) * len(history.robots) <= _MOST_POSES:
            break
    per_s = round(1 / step) if step < 1 else 1 / step  # 3/10, not 3 * 0.1
    times: Floats = np.arange(first, last + 1) / per_s + 0.0
    return times if len(times) else np.array([history.t0])


def fleet_entry(history: RunHistory, t: Floats) -> list[dict[str, Any]]:
    """Return what the page knows of each robot at times in s."""
    x, y, theta = history.poses_at(t)
    speeds = history.speeds_at(t)
    outlines = symbols(history.run)
    put = [history.put(*pair) for pair in zip(t[:-1].tolist(), t[1:].tolist(), strict=True)]
    return [
        {
            'number': robot,
            'name': robot_name(robot),
            'colour': to_hex(plot_colour(robot)),
            'bright': bool(edge_effects(plot_colour(robot), 1.0)),
            'outline': np.round(outlines[robot], 3).tolist(),
            'x': packed(x[:, column]),
            'y': packed(y[:, column]),
            'theta': packed(theta[:, column]),
            'v': packed(speeds[0, :, column]),
            'omega': packed(speeds[1, :, column]),
            'breaks': [k for k, robots in enumerate(put, 1) if robot in robots],
        }
        for column, robot in enumerate(history.robots)
    ]
