"""Fleets that are plotted in tests."""

import numpy as np
from matplotlib.figure import Figure
from runs import run_of

from setcmas_simu.fleet.fleet import start_poses
from setcmas_tools.plots.style import finish, plot_style
from setcmas_tools.run.fleet_motion import fleet_table


def circling_fleet(nb_robots, turns=1.5):
    """Robots that circle around their start poses, 12 s at 10 Hz, from 1 s before t = 0."""
    t = np.arange(-1.0, 11.0, 0.1)
    angle = 2 * np.pi * turns * (t - t[0]) / 12
    theta = np.arctan2(np.sin(angle), np.cos(angle))
    rows = [
        np.array([t, 0 * t + i, x + np.sin(angle), y - np.cos(angle), theta, 0 * t + 1, 0 * t]).T
        for i, (x, y, _) in enumerate(start_poses(nb_robots).T, start=1)
    ]
    return fleet_table(np.concatenate(rows))


def drawn(drawing, nb_robots):
    with plot_style():
        figure = Figure()
        drawing(figure, run_of(circling_fleet(nb_robots)))
        finish(figure, f'leader_follower_distance_formation, {nb_robots} robots')
        figure.draw_without_rendering()
    return figure
