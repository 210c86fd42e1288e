"""The plot `radius`: distance of each robot from the origin."""

import numpy as np


def draw_radius(figure, run):
    """Draw the distance from the origin over time into an empty figure."""
    axes = figure.add_subplot(title='Radius', xlabel='t (s)', ylabel='distance (m)')
    for robot in run.table.robots:
        track = run.table.of(robot)
        axes.plot(track.t, np.hypot(track.x, track.y), label=f'robot {robot}')
    axes.legend()
