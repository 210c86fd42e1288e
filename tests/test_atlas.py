"""Laws of the atlas: what they predict, and what they say where an assumption is broken."""

import numpy as np
import pytest

from setcmas_ctrl.network import reachable
from setcmas_tools import simulate

THEORY = {'model': 'omnidirectional', 'vnom': 50.0, 'rate': 25.0, 'robot_rate': 25.0}
RATE = 'consensus.convergence_rate_1_s'
LAWS = (
    'laplacian_consensus', 'finite_time_consensus', 'resilient_consensus', 'rendezvous',
    'containment', 'cyclic_pursuit',
)  # fmt: skip


@pytest.mark.parametrize(
    ('law', 'nb_robots', 'options'),
    [
        ('laplacian_consensus', 4, {'graph': 'path'}),
        ('laplacian_consensus', 5, {'graph': 'directed_ring', 'random_poses': 'auto'}),
        ('laplacian_consensus', 8, {'graph': 'star', 'set': {'K': 0.1}}),
        ('containment', 8, {'graph': 'ring'}),
        ('cyclic_pursuit', 5, {}),
        ('cyclic_pursuit', 5, {'graph': 'path'}),
        ('cyclic_pursuit', 6, {'set': {'ALPHA': 0.0}, 'random_poses': 'auto'}),
    ],
)
def test_robots_of_the_theory_end_where_a_linear_law_predicts(law, nb_robots, options):
    options['set'] = {'SLOW': 0.0} | options.get('set', {})
    run = simulate(law, nb_robots, 40.0, **options, **THEORY)
    figures = run.metrics()['prediction'].figures

    assert figures['distance_from_predicted_end_m'].measured < 1e-6
    if law == 'laplacian_consensus':
        assert figures[RATE].measured == pytest.approx(figures[RATE].predicted, rel=0.01)


def test_the_end_is_predicted_between_two_calls():
    options = {**THEORY, 'rate': 1.0, 'set': {'SLOW': 0.0}}
    for duration in (4.0, 4.4, 4.6):
        metrics = simulate('laplacian_consensus', 4, duration, graph='path', **options).metrics()
        assert metrics['prediction'].figures['distance_from_predicted_end_m'].measured < 1e-6


def test_a_directed_graph_that_is_not_balanced_has_another_meeting_point(tmp_path):
    graph = tmp_path / 'tree.yaml'
    graph.write_text('edges: [2 <- 1, 3 <- 1, 3 <- 2]\n')
    run = simulate('laplacian_consensus', 3, 60.0, graph=str(graph), set={'SLOW': 0.0}, **THEORY)

    assert run.poses[-1, :2] == pytest.approx(np.repeat(run.poses[0, :2, :1], 3, 1), abs=1e-3)


def test_cyclic_pursuit_ends_on_the_circle_of_the_theory():
    run = simulate('cyclic_pursuit', 5, 200.0, **THEORY, random_poses='auto', seed=3)
    z = run.poses[:, 0] + 1j * run.poses[:, 1]
    radius = np.abs(np.fft.fft(z[0])[-1]) / 5
    ring = z[-1] - z[-1].mean()

    assert np.abs(ring) == pytest.approx(radius, rel=0.1)  # sampling widens it a little
    gaps = np.diff(np.sort(np.angle(ring)))
    assert gaps == pytest.approx(2 * np.pi / 5, rel=0.02)


@pytest.mark.parametrize('graph', ['ring', 'complete'])
def test_finite_time_consensus_meets_before_its_bound(graph):
    run = simulate('finite_time_consensus', 6, 60.0, graph=graph, **THEORY)
    found = run.metrics()['prediction'].figures['consensus.settling_time_2_percent_s']

    assert found.measured < found.predicted


def test_the_bound_of_finite_time_consensus_counts_small_weights(tmp_path):
    (tmp_path / 'weak.yaml').write_text('edges: [1 <- 2: 0.1, 2 <- 1: 0.1]\n')
    options = {'graph': str(tmp_path / 'weak.yaml'), 'set': {'K': 2.0, 'SLOW': 0.0}}
    run = simulate('finite_time_consensus', 2, poses=[[0, 1], [0, 0], [0, 0]], **options, **THEORY)
    found = run.metrics()['prediction'].figures['consensus.settling_time_2_percent_s']

    assert found.measured < found.predicted < 1.5 * found.measured


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize('edges', ['1 - 2, 3 - 4', '1 <- 2, 2 <- 3, 3 <- 4, 4 <- 1'])
def test_without_an_undirected_connected_graph_finite_time_consensus_has_no_bound(
    tmp_path, capsys, edges
):
    (tmp_path / 'graph.yaml').write_text(f'edges: [{edges}]\n')
    run = simulate('finite_time_consensus', 4, 2.0, graph=str(tmp_path / 'graph.yaml'))

    assert 'prediction' not in run.metrics()
    assert 'failed' not in capsys.readouterr().out


def test_rebels_do_not_lead_honest_robots_out_of_the_interval_of_their_starts():
    run = simulate('resilient_consensus', 7, 60.0, set={'RADIUS': 9.0}, **THEORY)
    honest = run.poses[:, :2, 1:]

    assert (honest.min(axis=(0, 2)) >= honest[0].min(axis=1) - 1e-9).all()
    assert (honest.max(axis=(0, 2)) <= honest[0].max(axis=1) + 1e-9).all()
    assert np.ptp(honest[-1], axis=1).max() < 0.1


@pytest.mark.parametrize('law', ['laplacian_consensus', 'containment', 'rendezvous'])
def test_unicycles_get_to_the_equilibrium_and_rest(law):
    run = simulate(law, 6, 90.0, graph='ring', range=6.0)

    assert np.abs(run.omega[-50:]).max() == 0.0
    if law == 'containment':
        figures = run.metrics()['prediction'].figures
        assert figures['distance_from_predicted_end_m'].measured < 0.2


def test_no_link_of_a_rendezvous_is_lost():
    run = simulate('rendezvous', 8, 40.0, range=6.0)

    assert run.record.changes[:, 3].min() == 1.0
    assert run.metrics()['consensus'].disagreement_at_end_m < 0.1


@pytest.mark.parametrize('seed', range(6))
@pytest.mark.parametrize('vnom', [0.5, 50.0])
def test_fast_robots_lose_no_link_of_a_rendezvous(vnom, seed):
    starts = {'random_poses': 'box=16x16,distance=1', 'seed': seed}
    run = simulate('rendezvous', 10, 40.0, range=6.0, **starts, **{**THEORY, 'vnom': vnom})

    broken = run.metrics()['prediction'].figures['messages.broken_links']
    assert (broken.measured, broken.predicted) == (0.0, 0.0)
    if reachable(run.record.adjacency(0.0, 10)).all():
        assert run.metrics()['consensus'].disagreement_at_end_m < 0.5


def test_links_that_are_longer_than_d_may_break():
    run = simulate('rendezvous', 4, 2.0)
    short = simulate('consensus', 4, 8.0, range=11.0, set={'K': -0.1})  # they drive apart

    assert 'prediction' not in run.metrics()
    assert short.metrics()['messages'].broken_links > 0


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize('law', LAWS)
@pytest.mark.parametrize(
    'options', [{'nb_robots': 1}, {'nb_robots': 2}, {'nb_robots': 4, 'graph': 'path', 'loss': 1.0}]
)
def test_few_robots_and_robots_that_never_receive_give_no_nan(capsys, law, options):
    said = []
    run = simulate(law, duration=3.0, warn=said.append, **options)

    assert np.isfinite(run.poses).all()
    assert said == []
    run.metrics()
    assert 'failed' not in capsys.readouterr().out


@pytest.mark.parametrize(
    ('law', 'options', 'line'),
    [
        ('laplacian_consensus', {'set': {'K': 3}}, 'too large for a sampling period of 0.2 s'),
        ('laplacian_consensus', {'graph': 'two.yaml'}, 'no directed spanning tree'),
        ('containment', {'graph': 'two.yaml'}, 'no leader reaches robots [4]'),
        ('cyclic_pursuit', {'nb_robots': 2}, 'needs at least three robots'),
        ('cyclic_pursuit', {'graph': 'path'}, 'robots [4] do not receive the robot that they'),
        ('finite_time_consensus', {'graph': 'directed_ring'}, 'the graph is directed'),
        ('resilient_consensus', {'graph': 'ring'}, 'the graph is not robust enough'),
        ('rendezvous', {}, 'a link is longer than D'),
    ],
)
def test_a_broken_assumption_is_one_line(tmp_path, monkeypatch, capsys, law, options, line):
    (tmp_path / 'two.yaml').write_text('edges: [1 - 2, 2 - 3]\n')
    monkeypatch.chdir(tmp_path)
    simulate(law, **{'nb_robots': 4, 'duration': 1.0, **options})

    assert capsys.readouterr().out.count(line) == 1
