import math
from pathlib import Path

import numpy as np
import pytest
from metrics_runs import T, table
from runs import measure

from setcmas_tools import simulate

ROOT = Path(__file__).parents[3]


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


def test_settling_is_for_good():
    values = np.where((T < 3) | ((T >= 8) & (T < 8.5)), 1.0, 0.01)
    again = measure(table((T, values, 0), (T, -values, 0)))['consensus']
    never = measure(table((T, 1.0, 0), (T, -1.0, 0)))['consensus']

    assert again.settling_time_5_percent_s == pytest.approx(8.5)
    assert never.settling_time_2_percent_s is None
    assert never.convergence_rate_1_s is None


def test_a_rate_is_not_fitted_to_the_plateau_of_the_dead_band():
    # Robots that are slower than 0.01 m/s do not turn: 0.0179 1/s with the time in which all are.
    chain = {'graph': 'path', 'random_poses': 'auto', 'seed': 3, 'set': {'K': 0.1}}
    run = simulate(str(ROOT / 'docs/studies/average.py'), 8, 250, **chain)

    slowest = 2 - 2 * math.cos(math.pi / 8)  # eigenvalue of the path's Laplacian
    found = run.metrics()['consensus'].convergence_rate_1_s
    assert found == pytest.approx(0.1 * slowest, rel=0.03)
    motions = run.metrics()['robots'].values()
    assert min(motion['time_in_dead_band_s'] for motion in motions) > 100


def test_robots_without_a_dead_band_are_fitted_to_the_end():
    place = {'poses': [[-1, 1], [0, 0], [0, 0]], 'model': 'omnidirectional', 'set': {'K': 0.02}}
    run = simulate(str(ROOT / 'docs/studies/average.py'), 2, 100, **place, graph='path')

    assert run.metrics()['consensus'].convergence_rate_1_s == pytest.approx(0.04, rel=0.05)


def test_a_law_that_is_not_a_consensus_reports_no_disagreement(tmp_path):
    apart = tmp_path / 'apart.py'
    apart.write_text('def control(robotNo, nbRobots, poses, t):\n    return robotNo - 1.5, 0\n')
    assert 'disagreement' not in str(simulate(apart, 2, 10).metrics())
    assert 'below 5 % not reached' in str(simulate('consensus', 2, 2).metrics())
