"""A model file of two robots, and whether another one says the same, for tests."""

from dataclasses import asdict
from pathlib import Path

import pytest

from setcmas_simu.robots.identified_robot import read_model_file

TRUTH = """limits: burger
robots:
  1:
    forward: {gain: 0.95, lag: 0.15, delay: 0.25}
    turn: {gain: 0.9, lag: 0.1, delay: 0.25}
  2:
    forward: {gain: 1.0, lag: 0.3, delay: 0.15}
    turn: {gain: 1.05, lag: 0.2, delay: 0.15}
"""


def assert_found(found, latency):
    """Each gain, lag and delay, which includes the latency of the lab in s, is within a tenth."""
    truth, model = read_model_file(Path('truth.yaml')), read_model_file(Path(found))
    for robot, true in truth.robots.items():
        for name in ('forward', 'turn'):
            own, known = (asdict(getattr(one, name)) for one in (model.robots[robot], true))
            known['delay'] += latency
            for one in ('gain', 'lag', 'delay'):
                assert own[one] == pytest.approx(known[one], rel=0.1), (robot, name, one)
