"""Two cameras that disagree: no jump at the seam, at different rates, or when one stops."""

import math

import numpy as np
import pytest

pytest.importorskip('cv2')

from setcmas_expe.camera.camera_fusion import OLDEST_S, FusedPoses
from setcmas_expe.camera.tag_detection import TagPose

SPEED = 0.2
BIAS = 0.02
"""Distance in m between what the two cameras see."""


def edge(camera, x):
    """Return the distance in px from the edge; the cameras overlap from x = -0.5 to 0.5 m."""
    return 300 * (0.5 - x if camera == 'left' else x + 0.5)


def crossing(rates, end=math.inf, shift=0.0):
    """Return the fused positions of a robot on its way from left to right, 100 a second."""
    fused = FusedPoses()
    found = []
    last = dict.fromkeys(rates, -math.inf)
    for t in np.arange(0.0, 6.0, 0.01):
        for camera, rate in rates.items():
            x = -0.6 + SPEED * (t - shift)
            if (
                t - last[camera] >= 1 / rate
                and edge(camera, x) > 0
                and (camera, t < end)
                != (
                    'right',
                    False,
                )
            ):
                last[camera] = t
                y = BIAS if camera == 'right' else 0.0
                fused.add(1, camera, t - shift, TagPose(x, y, math.pi, edge(camera, x)))
        pose = fused.pose(1, t)
        found.append((t, *(pose or (math.nan,) * 3)))
    return np.array(found)


@pytest.mark.parametrize('rates', [{'left': 30, 'right': 30}, {'left': 30, 'right': 11}])
def test_a_robot_crosses_the_seam_without_a_jump(rates):
    t, x, y, heading = crossing(rates, shift=0.03).T

    np.testing.assert_allclose(x, -0.6 + SPEED * t, atol=0.02)
    assert np.abs(np.diff(y)).max() < BIAS / 5
    assert y[10] == 0.0
    assert y[-1] == BIAS
    assert np.abs(np.cos(heading) + 1).max() < 1e-9


def test_a_camera_that_stops_moves_the_pose_gradually():
    t, _, y, _ = crossing({'left': 30, 'right': 30}, end=3.0).T

    assert y[t < 2.9].max() > 0.3 * BIAS
    assert np.abs(np.diff(y[t < 5])).max() < BIAS / 5
    assert y[np.searchsorted(t, 3.0 + OLDEST_S + 0.1)] == 0.0


def test_a_heading_turns_on_past_half_a_turn():
    fused = FusedPoses()
    for t, heading in ((0.0, math.pi - 0.01), (0.1, -math.pi + 0.01)):
        fused.add(1, 'left', t, TagPose(0.0, 0.0, heading, 200.0))

    assert fused.pose(1, 0.15)[2] == pytest.approx(-math.pi + 0.02)


def test_an_old_pose_is_not_used():
    fused = FusedPoses()
    fused.add(1, 'left', 1.0, TagPose(0.0, 0.0, 0.0, 200.0))
    fused.add(1, 'left', 0.5, TagPose(9.0, 0.0, 0.0, 200.0))

    assert fused.pose(1, 1.1) == (0.0, 0.0, 0.0)
    assert fused.pose(1, 1.0 + OLDEST_S) is None
    assert fused.pose(2, 1.0) is None
