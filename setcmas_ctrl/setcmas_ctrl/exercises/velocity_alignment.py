"""Exercise: velocity alignment. The robots agree on a velocity by messages, and drive with it.

Goal
    At the start each robot drives in a direction of its own. Robots send their velocities. Compute
    the new velocity of each from those of its neighbours, so that all end with the same velocity.

Formula to implement
    w_i(k + 1) = w_i(k) + h K sum_j a_ij (w_j(k) - w_i(k)), v_i = w_i

    with the time h since the previous call (0 at the first). w_i is sent at each call, and
    w_j(k) is the value received from robot j.

What to observe
    1. Which velocity do all have at the end? Compare with the mean of those at the start.
    2. How fast do they align in the graph ring with 4, 8 and 16 robots? In theory at the rate
       K lambda_2.
    3. What changes with a delay of 1 s, and with a loss of 0.3?

Commands
    setcmas check my_alignment    checks your solution
    setcmas run --algo my_alignment --nb-robots 8 --graph ring --duration 40
"""

import numpy as np

from setcmas_ctrl import network

task = 'alignment'  # selects its metrics and plots
exercise = 'velocity_alignment'  # selects its tests

K = 0.3  # gain (1/s)
SPEED = 0.2  # at the start (m/s)
SPREAD = 3.0  # angle between the directions of the first and the last robot at the start (rad)

velocity = None  # w_i (m/s): a state; every robot has its own
before = None  # time of the call before (s)


def control(robotNo, nbRobots, poses, t):
    """Return the new velocity (vx, vy) in m/s of the robot."""
    global velocity, before
    if before is None:  # at the first call
        angle = np.linspace(-SPREAD / 2, SPREAD / 2, nbRobots)[robotNo - 1]
        velocity, before = SPEED * np.array([np.cos(angle), np.sin(angle)]), t
    h, before = t - before, t
    weights = network.adjacency()[robotNo - 1]  # a_ij for j = 1 to N
    for j, message in network.received().items():  # j: number of the sender, from 1
        other = message.value  # w_j (m/s)
        # TODO 1: sum the terms
    # TODO 2: compute the new velocity, send it with network.send, and return it
    return 0.0, 0.0
