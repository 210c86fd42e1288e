"""Exercise: coverage. Robots spread over a box, each towards the centroid of its Voronoi cell.

Goal
    The Voronoi cell of robot i contains the points of the box that are nearer to robot i than to
    any other robot. Compute each robot's velocity, so that every robot ends in the centroid of its
    own cell.

Formula to implement
    v_i = K (C_i - p_i), with the centroid C_i of the cell of robot i

    Approximate C_i by the mean of those grid points, in the array grid, that are in the cell. A
    robot whose cell contains no grid point stands still.

What to observe
    1. The cost H in the metrics never rises. Why?
    2. Try several seeds of --random-poses. Do the robots always end in the same places?
    3. Start eight robots on a line y = 0 of a flat box, --set BOX=[[0,-0.1],[8,0.1]]. Where do
       they end?

Commands
    setcmas new my_coverage --from coverage --exercise    a copy of this file to edit
    setcmas check my_coverage                             checks your solution
    setcmas run --algo my_coverage --nb-robots 6 --random-poses box=4x4,distance=0.8 --duration 30
"""

import numpy as np

task = 'coverage'  # selects its metrics and plots
exercise = 'coverage'  # selects the tests of setcmas check

K = 0.5  # gain (1/s)
BOX = [[-6, -6], [6, 6]]  # lower left and upper right corner (m)

shares = (np.arange(60) + 0.5) / 60
columns, rows = [low + shares * (high - low) for low, high in np.transpose(BOX)]
grid = np.array([[x, y] for x in columns for y in rows])  # 3,600 points of the box (m)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s towards the centroid of the robot's cell."""
    positions = poses[:2].T  # row j - 1: position of robot j (m)
    # TODO: find the grid points that are nearest to this robot, and move to their mean
    return 0.0, 0.0
