"""The section *Model* of docs/control_scripts.md is complete: written from it alone, a simulator
of unicycles gets the numbers of `simulate` to the last bit."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from setcmas_simu.fleet.fleet import start_poses
from setcmas_tools import simulate

PAGE = (Path(__file__).parents[1] / 'docs' / 'control_scripts.md').read_text()
MODEL = PAGE.partition('\n## Model\n')[2].partition('\n## ')[0]
BURGER = (0.2108, 2.635, 0.2667, 0.160)
WAFFLE = (0.2661, 1.854, 0.2667, 0.287)


def simulator(control, poses, duration, rate=5, robot_rate=10, vnom=0.5, komega=1.5):
    """The model, from the page."""
    poses = np.array(poses, dtype=float)
    nb_robots = poses.shape[1]
    Ts, calls, states = 1 / robot_rate, 0, [heard(poses)]
    for k in range(max(1, round(duration * robot_rate))):
        while calls / rate < (k + 1) * Ts - 1e-9:
            robots = range(1, nb_robots + 1)
            v = np.array([control(i, nb_robots, heard(poses), calls / rate) for i in robots]).T
            v = v * (vnom / np.maximum(np.hypot(*v), vnom))
            v = v.astype(np.float32).astype(float)
            V = np.hypot(*v)
            error = np.arctan2(v[1], v[0]) - heard(poses)[2]
            omega = komega * (np.pi - np.mod(np.pi - error, 2 * np.pi))
            omega[(V < 0.01) | (np.abs(omega) < 0.01)] = 0
            calls += 1
        poses[2] += Ts * omega
        poses[0] += Ts * V * np.cos(poses[2])
        poses[1] += Ts * V * np.sin(poses[2])
        states.append(heard(poses))
    return np.array(states)


def heard(poses):
    """What messages hand over: headings that went through a quaternion."""
    x, y, theta = poses
    z, w = np.sin(theta / 2), np.cos(theta / 2)
    return np.array([x, y, np.arctan2(2 * w * z, w * w - z * z)])


def swing(robotNo, nbRobots, poses, t):
    """Asks for all that a law can: fast, slow, backwards, by time and by heading."""
    x, y, theta = poses[:, robotNo - 1]
    if math.sin(0.7 * t) > 0.9:
        return 0.009 * math.cos(t), 0.0
    return 3 * math.cos(0.4 * t + robotNo) - 0.1 * x, math.sin(theta) - 0.1 * y


@pytest.mark.parametrize(
    'options',
    [{}, {'rate': 3.0}, {'rate': 20.0}, {'robot_rate': 50.0, 'vnom': 0.2, 'komega': 3.0}],
    ids=str,
)
def test_a_simulator_written_from_the_page_gets_the_same_numbers(options):
    ours = simulator(swing, start_poses(8), 60, **options)

    assert np.array_equal(ours, np.asarray(simulate(swing, 8, 60, **options).poses))


def test_the_page_has_the_numbers_that_the_simulator_uses():
    assert MODEL
    for number in [
        '10^{-9}',
        *(
            f'{value:g}'
            for value in (*BURGER[:3], *WAFFLE, 0.33, 0.4189, 0.1, 0.01, 0.5, 1.5, 5, 10)
        ),
    ]:
        assert re.search(rf'(?<![\d.]){re.escape(number)}(?!\d)', MODEL), number
