"""Laws of the atlas that agree on velocities or phases by messages, and bad use of all laws."""

import numpy as np
import pytest

from setcmas_ctrl.communication.graph import PRESETS, laplacian
from setcmas_ctrl.laws.script_loader import ALGORITHMS
from setcmas_tools import simulate

THEORY = {'model': 'omnidirectional', 'vnom': 50.0, 'rate': 25.0, 'robot_rate': 25.0}
EXACT = {**THEORY, 'set': {'SLOW': 0.0}}
LAWS = ('velocity_alignment', 'second_order_consensus', 'kuramoto')
RATE, LAG = 'alignment.convergence_rate_1_s', 'alignment.spread_of_directions_at_end_rad'


def figures(run):
    return run.metrics()['prediction']


@pytest.mark.parametrize(('graph', 'count'), [('path', 4), ('ring', 8)])
def test_velocities_align_at_the_predicted_rate_and_keep_their_mean(graph, count):
    run = simulate('velocity_alignment', count, 60.0, graph=graph, **THEORY)
    found = figures(run)
    second = np.linalg.eigvalsh(laplacian(PRESETS[graph](count)))[1]

    rate = found.figure(RATE)
    assert rate.measured == pytest.approx(rate.predicted, rel=0.01)
    assert rate.predicted == pytest.approx(0.3 * second, rel=0.05)  # sampled at 25 Hz
    for name in ('alignment.final_mean_vx_m_s', 'alignment.final_mean_vy_m_s'):
        mean = found.figure(name)
        assert mean.measured == pytest.approx(mean.predicted, abs=1e-7)


def test_second_order_robots_meet_at_the_rate_of_their_slowest_mode():
    options = {**EXACT, 'rate': 5.0, 'robot_rate': 10.0, 'random_poses': 'auto'}
    run = simulate('second_order_consensus', 4, 200.0, graph='ring', **options)
    deltas = run.poses[:, :2] - run.poses[:, :2].mean(axis=2, keepdims=True)
    sizes = np.linalg.norm(deltas, axis=(1, 2))
    peaks = np.maximum.accumulate(sizes[::-1])[::-1] / sizes[0]  # from now on
    counted = (peaks > 1e-7) & (peaks < 0.1) & (run.t < 190.0)
    rate = -np.polyfit(run.t[counted], np.log(peaks[counted]), 1)[0]

    assert rate == pytest.approx(figures(run).figures[0].predicted, rel=0.03)


@pytest.mark.parametrize('difference', [0.1, 0.29])
def test_two_circling_robots_lock_with_the_predicted_lag(difference):
    run = simulate('kuramoto', 2, 120.0, set={'DW': difference})
    lag = figures(run).figure(LAG)

    assert lag.predicted == pytest.approx(np.arcsin(difference / 0.3))
    assert lag.measured == pytest.approx(lag.predicted, rel=0.01)
    assert np.ptp(run.poses[-1, 2]) == pytest.approx(lag.predicted, rel=0.02)


def test_phases_of_a_complete_graph_converge_at_the_rate_k():
    options = {'set': {'DW': 0.0}, 'random_poses': 'auto', 'seed': 1}
    rate = figures(simulate('kuramoto', 6, 60.0, **options, **THEORY)).figure(RATE)

    assert rate.predicted == pytest.approx(0.3, rel=0.01)
    assert rate.measured == pytest.approx(rate.predicted, rel=0.01)


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize(
    'law', [name for name in ALGORITHMS.plugins() if not name.startswith('leader_follower')]
)
@pytest.mark.parametrize(
    'options', [{'nb_robots': 1}, {'nb_robots': 4, 'graph': 'path', 'loss': 1.0}]
)
def test_few_robots_and_robots_that_never_receive_give_no_nan(capsys, law, options):
    said = []
    run = simulate(law, duration=3.0, warn=said.append, **options)

    assert np.isfinite(run.poses).all()
    if law in LAWS:
        late = np.abs(run.velocities[run.control_t > 1.9]).max()
        assert late == 0.0
    assert said == []
    run.metrics()
    assert 'failed' not in capsys.readouterr().out
