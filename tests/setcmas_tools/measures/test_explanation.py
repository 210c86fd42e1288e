import math

import numpy as np
import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools import simulate
from setcmas_tools.measures.explanation import explanation, explanation_table
from setcmas_tools.run.scenario import Scenario

ROBOT = """
  {}:
    forward: {{gain: 0.8, lag: 0.3, delay: 0.1}}
    turn: {{gain: 1.0, lag: 0.1, delay: 0.0}}
"""


@pytest.fixture(scope='module')
def steps():
    """The steps of eight robots that meet."""
    scenario = Scenario.of('consensus', nb_robots=8, duration=20.0)
    return explanation(simulate(scenario), scenario)


def test_each_step_adds_one_thing(steps):
    assert [step.name for step in steps] == [
        'single integrators', 'sampled', 'with speed limit', 'with dead band', 'as unicycle',
        'as recorded',
    ]  # fmt: skip
    assert steps[-1].distance == 0.0  # the engine of the run is that of its steps


def test_the_first_steps_are_those_of_theory(steps):
    """Each robot goes to the mean of all, p' = -K (p - mean), every 0.2 s from step 2 on."""
    gain, period = 0.5, 0.2
    grid = steps[0].run.counted_grid
    starts = np.array([grid.x[:, 0], grid.y[:, 0]])
    mean = starts.mean(axis=1)
    assert steps[0].end == pytest.approx(mean, abs=1e-6)
    decay = np.exp(-gain * grid.t)
    x = mean[0] + np.outer(starts[0] - mean[0], decay)
    assert np.abs(grid.x - x).max() < 0.01
    assert steps[0].error_and_rate[1] == pytest.approx(gain, rel=0.005)
    sampled = -math.log(1 - period * gain) / period
    assert steps[1].error_and_rate[1] == pytest.approx(sampled, rel=1e-3)


def test_unicycles_that_face_one_way_move_the_centre(steps):
    """It goes to (0.249, 0.019) m; the dead band only leaves them 0.019 m apart."""
    assert steps[3].end == pytest.approx((0.0, 0.0), abs=1e-6)
    assert steps[3].error_and_rate[0] == pytest.approx(0.019, abs=0.002)
    assert steps[4].end == pytest.approx((0.249, 0.019), abs=0.001)


def test_messages_a_filter_and_identified_robots_are_steps(tmp_path):
    (tmp_path / 'robots.yaml').write_text('robots:' + ''.join(map(ROBOT.format, (1, 2, 3))))
    scenario = Scenario.of(
        'consensus', nb_robots=3, duration=12.0, delay=0.4, loss=0.2, filter='barrier',
        model=tmp_path / 'robots.yaml',
    )  # fmt: skip
    steps = explanation(simulate(scenario), scenario)

    assert [step.name for step in steps[4:]] == [
        'as unicycle', 'with delay and loss', 'with safety filter', 'as identified robot',
        'as recorded',
    ]  # fmt: skip
    assert all(steps[number].distance > 0.0 for number in (5, 7))  # no robot is near another


def test_a_law_without_dead_band_has_no_step_of_it():
    def control(robotNo, nbRobots, poses, t):
        return -poses[0, robotNo - 1], -poses[1, robotNo - 1]

    scenario = Scenario.of(control, nb_robots=2, duration=2.0)
    with pytest.raises(SetcmasError, match='the law of this run is no script'):
        explanation(simulate(scenario), scenario)
    scenario = Scenario.of('kuramoto', nb_robots=2, duration=2.0)
    names = [step.name for step in explanation(simulate(scenario), scenario)]
    assert 'with dead band' not in names
    assert names[-2:] == ['as unicycle', 'as recorded']


def test_a_robot_without_poses_has_no_start():
    run = simulate('consensus', 2, 1.0)
    with pytest.raises(SetcmasError, match='robot 3 has no pose in this run'):
        explanation(run, Scenario.of('consensus', nb_robots=3))


def test_the_table_has_a_row_for_each_step(steps):
    lines = explanation_table(steps).splitlines()

    assert lines[3].split() == ['single', 'integrators', '0.000', '0.000', '0.000', '0.501', '-']
    assert lines[-1].split()[:4] == ['as', 'recorded', '0.249', '0.019']
