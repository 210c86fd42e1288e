import math

import numpy as np

from setcmas_simu.robots.unicycle import Unicycle
from setcmas_simu.robots.virtual_fleet import VirtualFleet


def test_robots_stand_until_commanded_and_then_hold_their_command():
    start = np.array([[1.0, 2.0], [0.0, 0.0], [0.0, math.pi]])
    fleet = VirtualFleet(start, Unicycle())
    fleet.step(0.1)
    np.testing.assert_array_equal(fleet.poses, start)

    fleet.command_all(np.array([[0.0, 0.5], [0.0, 0.0], [0.0, 0.0]]))
    for _ in range(10):
        fleet.step(0.1)

    np.testing.assert_allclose(fleet.poses[0], [1.0, 1.5])
    assert fleet.states[3].tolist() == [0.0, 0.5]
