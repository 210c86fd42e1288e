"""Laws of the atlas do what theory says of them, where its assumptions hold."""

import numpy as np
import pytest

from setcmas_tools import simulate

THEORY = {'model': 'omnidirectional', 'vnom': 50.0, 'rate': 25.0, 'robot_rate': 25.0}
SPARSE = {'graph': 'ring', 'range': 6.0}


def test_a_directed_graph_that_is_not_balanced_has_another_meeting_point(tmp_path):
    graph = tmp_path / 'tree.yaml'
    graph.write_text('edges: [2 <- 1, 3 <- 1, 3 <- 2]\n')
    run = simulate('laplacian_consensus', 3, 60.0, graph=str(graph), set={'SLOW': 0.0}, **THEORY)

    assert run.poses[-1, :2] == pytest.approx(np.repeat(run.poses[0, :2, :1], 3, 1), abs=1e-3)


def test_rebels_do_not_lead_honest_robots_out_of_the_interval_of_their_starts():
    run = simulate('resilient_consensus', 7, 60.0, set={'RADIUS': 9.0}, **THEORY)
    honest = run.poses[:, :2, 1:]

    assert (honest.min(axis=(0, 2)) >= honest[0].min(axis=1) - 1e-9).all()
    assert (honest.max(axis=(0, 2)) <= honest[0].max(axis=1) + 1e-9).all()
    assert np.ptp(honest[-1], axis=1).max() < 0.1
    metrics = run.metrics()
    assert metrics['honest'].largest_exit_m < 1e-9
    assert metrics['honest'].disagreement_at_end_m < 0.1


def test_more_rebels_than_expected_lead_honest_robots_away():
    rebels = {'REBELS': [1, 2], 'F': 1, 'RADIUS': 9.0}
    metrics = simulate('resilient_consensus', 6, 60.0, set=rebels, **THEORY).metrics()

    assert metrics['honest'].largest_exit_m > 1.0


@pytest.mark.parametrize('rebels', [[], [1, 2]])
def test_without_rebels_or_honest_robots_nothing_fails(rebels, capsys):
    metrics = simulate('resilient_consensus', 2, 3.0, set={'REBELS': rebels}).metrics()

    assert ('honest' in metrics) == (not rebels)
    assert 'failed' not in capsys.readouterr().out


@pytest.mark.parametrize(
    ('law', 'count', 'options'),
    [
        *((law, 6, SPARSE) for law in ('laplacian_consensus', 'rendezvous')),
        ('containment', 6, {'graph': 'ring'}),
        *((law, 5, {}) for law in ('distance_formation', 'bearing_formation', 'coverage')),
    ],
)
def test_unicycles_get_to_the_equilibrium_and_rest(law, count, options):
    run = simulate(law, count, 90.0, **options)
    metrics = run.metrics()

    assert np.abs(run.omega[-50:]).max() == 0.0
    if law == 'containment':
        adjacency = run.record.adjacency(0.0, 6)
        L = np.diag(adjacency.sum(axis=1)) - adjacency
        ends = -np.linalg.inv(L[3:, 3:]) @ L[3:, :3] @ run.poses[0, :2, :3].T
        assert np.hypot(*(run.poses[-1, :2, 3:] - ends.T)).max() < 0.2
    if law == 'distance_formation':
        assert metrics['distances'].distance_error_final_largest_m < 0.05


@pytest.mark.parametrize('vnom', [0.5, 50.0])
def test_fast_robots_lose_no_link_of_a_rendezvous(vnom):
    starts = {'random_poses': 'box=16x16,distance=1', 'seed': 0}
    run = simulate('rendezvous', 10, 40.0, range=6.0, **starts, **{**THEORY, 'vnom': vnom})

    assert run.metrics()['messages'].broken_links == 0
    if np.linalg.matrix_power(run.record.adjacency(0.0, 10) + np.eye(10), 10).all():
        assert run.metrics()['consensus'].disagreement_at_end_m < 0.5


def test_links_that_are_longer_than_d_may_break():
    short = simulate('consensus', 4, 8.0, range=11.0, set={'K': -0.1})  # they drive apart

    assert short.metrics()['messages'].broken_links > 0


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize(
    ('graph', 'count', 'apart'),
    [('complete', 4, 0.64), ('star', 5, 1.0)],
)
def test_sampled_finite_time_consensus_stays_as_far_apart_as_it_says(graph, count, apart):
    options = {'rate': 5.0, 'robot_rate': 5.0, 'set': {'K': 2.0, 'SLOW': 0.0}}
    run = simulate('finite_time_consensus', count, 100.0, graph=graph, **{**THEORY, **options})

    assert np.ptp(run.poses[-50:, :2], axis=2).max() == pytest.approx(apart)


@pytest.mark.parametrize(
    ('law', 'given', 'line'),
    [
        ('finite_time_consensus', {'ALPHA': -1}, 'ALPHA = -1; it must be above 0 and below 1'),
        ('laplacian_consensus', {'DELAY': -1.0}, 'DELAY = -1 s; it must be 0 s or more'),
    ],
)
def test_a_setting_that_cannot_be_stops_the_robots(law, given, line, capsys):
    run = simulate(law, 3, 1.0, set=given)

    assert run.failed_robots == [1, 2, 3]
    assert (run.velocities == 0).all()
    run.metrics()
    assert 'failed' not in capsys.readouterr().out


def test_distributed_optimisation_meets_at_the_minimiser_of_all_costs():
    weights = np.resize([1.0, 2.0, 4.0], 6)
    run = simulate('distributed_optimisation', 6, 120.0, graph='ring', **THEORY)
    minimiser = run.poses[0, :2] @ weights / weights.sum()

    assert np.hypot(*(run.poses[-1, :2] - minimiser[:, None])).max() < 0.05


def test_without_memory_distributed_optimisation_leaves_a_spread():
    options = {'graph': 'path', 'set': {'MEMORY': False, 'SLOW': 0.0}, **THEORY}
    run = simulate('distributed_optimisation', 5, 120.0, **options)
    L = np.diag([1, 2, 2, 2, 1]) - np.eye(5, k=1) - np.eye(5, k=-1)
    costs = 0.2 * np.diag(np.resize([1.0, 2.0, 4.0], 5))

    ends = run.poses[0, :2] @ costs @ np.linalg.inv(costs + 0.2 * L)
    assert run.poses[-1, :2] == pytest.approx(ends, abs=1e-3)
    assert run.metrics()['consensus'].disagreement_at_end_m > 1.0


IDEAL = {'set': {'SLOW': 0.0}, **THEORY}


def test_dynamic_average_follows_the_mean_of_ramps_with_the_error_of_theory():
    run = simulate('dynamic_average', 5, 120.0, graph='directed_ring', **IDEAL)
    figures = [one for one in run.metrics()['prediction'].figures if one.measured is not None]

    assert len(figures) == 3
    for figure in figures:
        assert figure.measured == pytest.approx(figure.predicted, rel=0.01)


SLOW_CALLS = {'rate': 5.0, 'robot_rate': 10.0}


@pytest.mark.parametrize(('rates', 'delay', 'age'), [({}, 1.0, 1.0), (SLOW_CALLS, 0.25, 0.3)])
def test_late_neighbours_move_the_meeting_point(rates, delay, age):
    options = {'graph': 'path', 'set': {'SLOW': 0.0}, 'random_poses': 'auto', **THEORY, **rates}
    run = simulate('laplacian_consensus', 4, 90.0, delay=delay, **options)
    weights = 1 + 0.2 * age * np.array([1, 2, 2, 1])

    meet = run.poses[0, :2] @ weights / weights.sum()
    assert run.poses[-1, :2] == pytest.approx(np.repeat(meet[:, None], 4, 1), abs=1e-3)


@pytest.mark.parametrize(('delay', 'meets'), [(0.84, True), (1.0, False)])
def test_robots_with_late_positions_meet_up_to_the_delay_of_theory(delay, meets):
    # K lambda_N = 0.5 (2 + sqrt(2)), so the bound is pi / (2 K lambda_N) = 0.92 s
    given = {'K': 0.5, 'DELAY': delay, 'SLOW': 0.0}
    run = simulate('laplacian_consensus', 4, 80.0, graph='path', delay=delay, set=given, **THEORY)
    agreement = run.metrics()['consensus']

    assert (agreement.disagreement_at_end_m < 0.1 * agreement.disagreement_at_start_m) == meets
