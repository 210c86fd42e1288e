"""The task `gathering`: robots meet at a centre."""

import numpy as np

from setcmas_ctrl.laws.references import points
from setcmas_tools.measures.metric import Value
from setcmas_tools.measures.task import Task


class Gathering(Task):
    """Takes CENTRES from the law, a list of one point in m."""

    def metrics(self, run, references):
        """Return the final distance of each robot from the centre."""
        x, y = references['CENTRES'][0]
        ends = {robot: run.counted.of(robot) for robot in run.counted.robots}
        gaps = {robot: np.hypot(end.x[-1] - x, end.y[-1] - y) for robot, end in ends.items()}
        return {'gathering': Value('to the centre', gaps, 'm')}

    def draw(self, plot, axes, run, references):
        """Mark the centre in the plane; return the entries for the legend."""
        del run
        if plot not in ('trajectories', 'film'):
            return []
        return axes.plot(*references['CENTRES'][0], 'k+', label='centre')


GATHERING = Gathering({'CENTRES': points})
