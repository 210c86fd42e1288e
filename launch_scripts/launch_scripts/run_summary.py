"""The few lines that a run ends with: who ended where, how far each went."""

from __future__ import annotations

import numpy as np

from setcmas_simu.topics import robot_name
from setcmas_tools.fleet_table import FleetTable


def summary_lines(table: FleetTable) -> list[str]:
    """Return what happened to a fleet, as lines of text.

    Args:
        table: The fleet's poses over time (m, rad, s).
    """
    last = {robot: _last_position(table, robot) for robot in table.robots}
    centre = np.mean(list(last.values()), axis=0)
    lines = [f'{"robot":>6}  {"path (m)":>8}  {"end x (m)":>9}  {"end y (m)":>9}  to centre (m)']
    for robot, position in last.items():
        x, y = position
        distance = np.hypot(*(position - centre))
        path = path_length(table, robot)
        lines.append(f'{robot_name(robot):>6}  {path:8.2f}  {x:9.2f}  {y:9.2f}  {distance:13.2f}')
    if len(last) > 1:
        places = np.array(list(last.values()))
        gaps = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
        lines.append(
            f'largest distance between two robots at the end: {gaps.max():.2f} m; '
            f'centre ({centre[0]:.2f}, {centre[1]:.2f})'
        )
    return lines


def path_length(table: FleetTable, robot: int) -> float:
    """Return how far a robot went, in m: the sum of its steps."""
    track = table.of(robot)
    return float(np.hypot(np.diff(track.x), np.diff(track.y)).sum())


def _last_position(table: FleetTable, robot: int) -> np.ndarray:
    track = table.of(robot)
    return np.array([track.x[-1], track.y[-1]])
