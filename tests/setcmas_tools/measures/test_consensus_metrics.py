import math

import numpy as np
import pytest
from metrics_runs import T, compute, table
from ros1_recordings import CONSENSUS
from runs import measure

from setcmas_tools import simulate


def test_two_robots_in_consensus_settle_when_theory_says():
    # d(k+1) = (1 - K T) d(k) with K = 0.5 /s and T = 0.1 s is at most a share s of d(0) from
    # k = ln(s) / ln(1 - K T), rounded up: 0.95^59 = 0.0485 and 0.95^77 = 0.0193.
    distance = 4.0 * 0.95 ** np.arange(len(T))
    agreement = measure(table((T, 1 + distance / 2, 2), (T, 1 - distance / 2, 2)))['consensus']

    assert agreement.disagreement_at_start_m == pytest.approx(2.0)
    assert agreement.disagreement_at_end_m == pytest.approx(2.0 * 0.95**200)
    assert agreement.settling_time_5_percent_s == pytest.approx(5.9)
    assert agreement.settling_time_2_percent_s == pytest.approx(7.7)
    assert agreement.convergence_rate_1_s == pytest.approx(-math.log(0.95) / 0.1)
    assert (agreement.final_centre_x_m, agreement.final_centre_y_m) == pytest.approx((1, 2))


def test_the_built_in_consensus_settles_when_theory_says():
    # Two robots that face each other: K = 0.5 /s, called each 0.2 s.
    run = simulate('consensus', 2, 12, poses=[[-0.9, 0.9], [0, 0], [0, math.pi]])
    agreement = measure(run.table)['consensus']

    theory = 0.2 * math.log(0.05) / math.log(1 - 0.5 * 0.2)
    assert agreement.settling_time_5_percent_s == pytest.approx(theory, abs=0.1)


def test_settling_is_for_good():
    values = np.where((T < 3) | ((T >= 8) & (T < 8.5)), 1.0, 0.01)
    again = measure(table((T, values, 0), (T, -values, 0)))['consensus']
    never = measure(table((T, 1.0, 0), (T, -1.0, 0)))['consensus']

    assert again.settling_time_5_percent_s == pytest.approx(8.5)
    assert never.settling_time_2_percent_s is None
    assert never.convergence_rate_1_s is None


def test_the_recording_of_the_ros_1_stack():
    metrics = compute(CONSENSUS)

    assert list(metrics['robots'].robots) == list(range(1, 9))
    agreement = metrics['consensus']
    # Four robots start at sqrt(50) m from the centre, four at 5 m.
    assert agreement.disagreement_at_start_m == pytest.approx(math.sqrt(37.5), abs=0.05)
    assert agreement.disagreement_at_end_m < 0.02 * agreement.disagreement_at_start_m
    assert agreement.settling_time_5_percent_s < agreement.settling_time_2_percent_s < 40
    for motion in metrics['robots'].robots.values():
        assert motion.largest_speed_m_s == pytest.approx(0.5)
        assert 4.0 < motion.path_length_m < 9.0
        assert 0 < motion.time_in_saturation_s < motion.path_length_m / 0.5 + 0.1
