import math

import numpy as np
import pytest

from setcmas_expe.emulation.emulated_lidar import ranges


def test_a_lidar_sees_the_nearest_thing_in_each_direction():
    discs = np.array([[1.0, 1.0, 0.15], [2.0, 1.0, 0.1], [1.0, 3.0, 0.2]]).T
    measured = ranges(np.array([1.0, 2.0, -math.pi / 2]), discs)

    assert measured[0] == pytest.approx(0.85)
    assert measured[45] == pytest.approx(math.sqrt(2) - 0.1, rel=1e-3)  # to its left
    assert measured[180] == pytest.approx(0.8)
    assert measured[90] == math.inf
