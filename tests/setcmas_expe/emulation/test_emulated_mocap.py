import math

import numpy as np
import pytest

from setcmas_expe.emulation.emulated_mocap import LATENCY_S, POSITION_NOISE, EmulatedMocap
from setcmas_expe.emulation.faults import Fault, FaultKind

POSES = np.array([[1.0, -1.0, 0.5], [2.0, 0.0, 0.5], [0.5, -0.5, 3.0]])


def mocap(y_up=False):
    return EmulatedMocap(3, y_up, np.random.default_rng(0))


def frame(system, now=0.0, poses=POSES):
    """Take a frame and return its sightings by body, however late they are."""
    system.capture(poses, now)
    return dict(system.due(math.inf))


@pytest.mark.parametrize('y_up', [False, True])
def test_poses_are_seen_with_a_little_noise(y_up):
    sightings = frame(mocap(y_up))

    for index in range(3):
        sample = sightings[index].z_up() if y_up else sightings[index]
        x, y, theta = sample.planar()
        assert (x, y) == pytest.approx(tuple(POSES[:2, index]), abs=6 * POSITION_NOISE)
        assert x != POSES[0, index]
        assert theta == pytest.approx(POSES[2, index], abs=0.02)
        assert sample.position[2] == pytest.approx(0.19)


def test_sightings_come_after_the_latency_and_once():
    system = mocap()
    system.capture(POSES, 1.0)

    assert system.due(1.0) == []
    assert {sample.stamp for _, sample in system.due(1.0 + LATENCY_S)} == {1.0}
    assert system.due(2.0) == []


def test_faults_end():
    system = mocap()
    system.begin(Fault(FaultKind.DROPOUT, 2, 1.0), 5.0)

    assert set(frame(system, 5.5)) == {0, 2}
    assert set(frame(system, 6.0)) == {0, 1, 2}


def test_poses_stay_in_order_when_they_are_no_longer_late():
    system = mocap()
    system.begin(Fault(FaultKind.LATE, 1, 0.5), 0.0)
    system.capture(POSES, 0.4)
    system.capture(POSES, 0.6)

    assert [sample.stamp for body, sample in system.due(1.0) if body == 0] == []
    assert [sample.stamp for body, sample in system.due(1.5) if body == 0] == [0.4, 0.6]
