"""Poses from the robots' own sensors: placed at their start, and stopped before they are wrong."""

import math

import pytest

from setcmas_expe.mocap.dead_reckoning import LONGEST_S, MOST_DRIFT_M, DeadReckoning
from setcmas_expe.mocap.sources import Sample
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw


def sample(x, y, theta, stamp=0.0):
    z, w = quaternion_of_yaw(theta)
    return Sample((x, y, 0.0), (0.0, 0.0, z, w), stamp)


def test_odometry_counts_from_the_start_pose():
    reckoning = DeadReckoning((2.0, 1.0, math.pi / 2))

    first = reckoning.placed(sample(5.0, 5.0, math.pi), 0.0)
    ahead = reckoning.placed(sample(4.0, 5.0, math.pi / 2), 1.0)

    assert first.planar() == pytest.approx((2.0, 1.0, math.pi / 2))
    assert ahead.planar() == pytest.approx((2.0, 2.0, 0.0))
    assert reckoning.way == 1.0


def test_drift_grows_with_the_way_until_the_robot_must_stop():
    straight, round_and_round = DeadReckoning((0, 0, 0)), DeadReckoning((0, 0, 0))
    for step in range(200):
        straight.placed(sample(0.01 * step, 0.0, 0.0), 0.1 * step)
        round_and_round.placed(sample(0.01 * step, 0.0, 0.1 * step), 0.1 * step)

    assert 0.02 < straight.drift < 0.04  # of 2 m
    assert round_and_round.drift > 3 * straight.drift
    assert straight.trouble == ''

    step = 200
    while not straight.trouble:
        step += 1
        straight.placed(sample(0.01 * step, 0.0, 0.0), 20.0)
    assert straight.drift == pytest.approx(MOST_DRIFT_M, abs=0.002)
    assert 'put the robots at their start poses' in straight.trouble


def test_time_is_limited_from_the_first_move_on():
    reckoning = DeadReckoning((0, 0, 0))
    for now in (0.0, 1000.0):
        reckoning.placed(sample(0.0, 0.0, 0.0), now)
    assert not reckoning.trouble  # a robot at rest does not drift

    reckoning.placed(sample(0.01, 0.0, 0.0), 1001.0)
    reckoning.placed(sample(0.01, 0.0, 0.0), 1002.0 + LONGEST_S)
    assert reckoning.trouble.startswith('wheel odometry may be')


def test_odometry_that_counts_from_zero_again_is_found():
    reckoning = DeadReckoning((0.5, -1.0, 0.0))
    for now, x in ((0.0, 0.0), (1.0, 0.1), (30.0, 0.1), (30.1, 0.0)):
        reckoning.placed(sample(x, 0.0, 0.0), now)
        assert not reckoning.trouble  # it may drive back, or be silent for a while

    reckoning.placed(sample(0.1, 0.0, 0.0), 31.0)
    reckoning.placed(sample(0.0, 0.0, 0.0), 60.0)
    assert 'counts from 0 again' in reckoning.trouble


def test_invalid_odometry_is_left_to_the_checks_of_all_poses():
    reckoning = DeadReckoning((0, 0, 0))
    invalid = sample(math.nan, 0.0, 0.0)

    assert reckoning.placed(invalid, 0.0) is invalid
    assert reckoning.placed(sample(0.0, 0.0, 0.0), 0.1).planar() == (0.0, 0.0, 0.0)
