"""Laws of the atlas: what they predict, and what they say where an assumption is broken."""

import numpy as np
import pytest

from setcmas_ctrl.network import reachable
from setcmas_ctrl.scripts.loader import ALGORITHMS
from setcmas_tools import Scenario, simulate

THEORY = {'model': 'omnidirectional', 'vnom': 50.0, 'rate': 25.0, 'robot_rate': 25.0}
RATE = 'consensus.convergence_rate_1_s'
SPARSE = {'graph': 'ring', 'range': 6.0}
FLAT = {'BOX': [[-6, 0], [6, 3]]}


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
        ('distributed_optimisation', 6, {'graph': 'ring', 'random_poses': 'auto'}),
        ('distributed_optimisation', 5, {'graph': 'path', 'set': {'MEMORY': False}}),
        ('laplacian_consensus', 5, {'graph': 'star', 'delay': 0.5, 'random_poses': 'auto'}),
        ('laplacian_consensus', 4, {'delay': 1.2, 'set': {'DELAY': 1.2}, 'random_poses': 'auto'}),
        ('bearing_formation', 5, {}),
        ('bearing_formation', 6, {'graph': 'ring', 'random_poses': 'auto'}),
        ('bearing_formation', 3, {'graph': 'directed_ring'}),
        ('coverage', 1, {'poses': [[-1], [2], [0]]}),
        ('coverage', 4, {'poses': [[3, -1, 0, -5.5], [2] * 4, [0] * 4], 'set': FLAT}),
    ],
)
def test_robots_of_the_theory_end_where_a_linear_law_predicts(law, nb_robots, options):
    options['set'] = {'SLOW': 0.0} | options.get('set', {})
    run = simulate(law, nb_robots, 40.0, **options, **THEORY)
    figures = run.metrics()['prediction'].figures

    assert figures['distance_from_predicted_end_m'].measured < 1e-6
    if figures.get(RATE):
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

    assert not run.metrics()['prediction'].figures
    assert 'failed' not in capsys.readouterr().out


def test_rebels_do_not_lead_honest_robots_out_of_the_interval_of_their_starts():
    run = simulate('resilient_consensus', 7, 60.0, set={'RADIUS': 9.0}, **THEORY)
    honest = run.poses[:, :2, 1:]

    assert (honest.min(axis=(0, 2)) >= honest[0].min(axis=1) - 1e-9).all()
    assert (honest.max(axis=(0, 2)) <= honest[0].max(axis=1) + 1e-9).all()
    assert np.ptp(honest[-1], axis=1).max() < 0.1
    metrics = run.metrics()
    figure = metrics['prediction'].figures['honest.largest_exit_m']
    assert figure.measured < 1e-9
    assert figure.predicted == 0.0
    assert metrics['honest'].disagreement_at_end_m < 0.1


def test_more_rebels_than_expected_lead_honest_robots_away():
    rebels = {'REBELS': [1, 2], 'F': 1, 'RADIUS': 9.0}
    metrics = simulate('resilient_consensus', 6, 60.0, set=rebels, **THEORY).metrics()

    assert not metrics['prediction'].figures
    assert 'F = 1, but robots [1, 2] disobey' in str(metrics)
    assert metrics['honest'].largest_exit_m > 1.0


@pytest.mark.parametrize('rebels', [[], [1, 2]])
def test_without_rebels_or_honest_robots_nothing_fails(rebels, capsys):
    metrics = simulate('resilient_consensus', 2, 3.0, set={'REBELS': rebels}).metrics()

    assert ('honest' in metrics) == (not rebels)
    assert 'failed' not in capsys.readouterr().out


@pytest.mark.parametrize(
    ('law', 'count', 'options'),
    [
        *((law, 6, SPARSE) for law in ('laplacian_consensus', 'containment', 'rendezvous')),
        *((law, 5, {}) for law in ('distance_formation', 'bearing_formation', 'coverage')),
    ],
)
def test_unicycles_get_to_the_equilibrium_and_rest(law, count, options):
    run = simulate(law, count, 90.0, **options)
    metrics = run.metrics()

    assert np.abs(run.omega[-50:]).max() == 0.0
    if law == 'containment':
        figures = metrics['prediction'].figures
        assert figures['distance_from_predicted_end_m'].measured < 0.2
    if law == 'distance_formation':
        assert metrics['distances'].distance_error_final_largest_m < 0.05


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

    assert not run.metrics()['prediction'].figures
    wide = simulate('rendezvous', 8, 2.0, range=4.0, random_poses='auto')  # its D is 6 m
    assert 'the law predicts nothing' in str(wide.metrics())
    assert short.metrics()['messages'].broken_links > 0


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize(
    ('graph', 'count', 'apart'),
    [('complete', 2, 0.16), ('complete', 4, 0.64), ('ring', 6, 0.64), ('star', 5, 1.0)],
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
def test_a_setting_that_cannot_be_stops_the_robots_and_predicts_nothing(law, given, line, capsys):
    run = simulate(law, 3, 1.0, set=given)

    assert run.failed_robots == [1, 2, 3]
    assert (run.velocities == 0).all()
    assert not run.metrics()['prediction'].figures
    assert 'failed' not in capsys.readouterr().out


def test_distributed_optimisation_meets_at_the_minimiser_of_all_costs():
    weights = np.resize([1.0, 2.0, 4.0], 6)
    for options in (THEORY, {}):
        run = simulate('distributed_optimisation', 6, 120.0, graph='ring', **options)
        minimiser = run.poses[0, :2] @ weights / weights.sum()

        away = np.hypot(*(run.poses[-1, :2] - minimiser[:, None]))
        assert away.max() < (0.15 if not options else 0.05)  # robots rest below 0.01 m/s


def test_without_memory_distributed_optimisation_leaves_a_spread():
    options = {'graph': 'path', 'set': {'MEMORY': False, 'SLOW': 0.0}, **THEORY}
    run = simulate('distributed_optimisation', 5, 120.0, **options)
    L = np.diag([1, 2, 2, 2, 1]) - np.eye(5, k=1) - np.eye(5, k=-1)
    costs = 0.2 * np.diag(np.resize([1.0, 2.0, 4.0], 5))

    ends = run.poses[0, :2] @ costs @ np.linalg.inv(costs + 0.2 * L)
    assert run.poses[-1, :2] == pytest.approx(ends, abs=1e-3)
    assert run.metrics()['consensus'].disagreement_at_end_m > 1.0


IDEAL = {'set': {'SLOW': 0.0}, **THEORY}


@pytest.mark.parametrize(
    ('graph', 'options', 'error'),
    [
        *(
            (graph, IDEAL, {'rel': 0.01})
            for graph in ('path', 'ring', 'directed_ring', 'complete')
        ),
        ('ring', {}, {'abs': 0.1}),  # unicycles
    ],
)
def test_dynamic_average_follows_the_mean_of_ramps_with_the_error_of_theory(graph, options, error):
    run = simulate('dynamic_average', 5, 120.0, graph=graph, **options)
    figures = run.metrics()['prediction'].figures

    assert len(figures) == 3
    for figure in figures.values():
        assert figure.measured == pytest.approx(figure.predicted, **error)


WITH_MESSAGES = (
    'dynamic_average',
    'kuramoto',
    'leader_election',
    'second_order_consensus',
    'velocity_alignment',
)
OTHERS = {*WITH_MESSAGES, *(name for name in ALGORITHMS.plugins() if 'leader_follower' in name)}
OF_POSES = sorted({*ALGORITHMS.plugins()} - OTHERS)
EACH_BY_ONE_ROBOT = ','.join(f'{i}:{name}' for i, name in enumerate(OF_POSES, 1))


@pytest.mark.parametrize('law', [*WITH_MESSAGES, EACH_BY_ONE_ROBOT])
def test_each_law_moves_robots_over_topics_as_offline(law, domain):
    pytest.importorskip('rclpy')
    from stepped_nodes import stepped_nodes

    count = len(OF_POSES) if law == EACH_BY_ONE_ROBOT else 4
    options = {'graph': 'ring', 'loss': 0.2, 'delay': 0.2, 'seed': 3}
    scenario = Scenario.of(law, nb_robots=count, duration=3.0, **options)
    with stepped_nodes(scenario, domain) as nodes:
        nodes.run()

    assert np.array_equal(nodes.poses, simulate(scenario).poses)


SLOW_CALLS = {'rate': 5.0, 'robot_rate': 10.0}


@pytest.mark.parametrize(
    ('rates', 'delay', 'age'), [({}, 1.0, 1.0), (SLOW_CALLS, 0.3, 0.3), (SLOW_CALLS, 0.25, 0.3)]
)
def test_late_neighbours_move_the_meeting_point(rates, delay, age):
    options = {'graph': 'path', 'set': {'SLOW': 0.0}, 'random_poses': 'auto', **THEORY, **rates}
    run = simulate('laplacian_consensus', 4, 90.0, delay=delay, **options)
    comparison = run.metrics()['prediction']
    weights = 1 + 0.2 * age * np.array([1, 2, 2, 1])

    meet = run.poses[0, :2] @ weights / weights.sum()
    assert run.poses[-1, :2] == pytest.approx(np.repeat(meet[:, None], 4, 1), abs=1e-3)
    assert comparison.figures['distance_from_predicted_end_m'].measured < 1e-6
    assert 'delay of messages' not in comparison.differs


@pytest.mark.parametrize(('delay', 'meets'), [(0.84, True), (1.0, False)])
def test_robots_with_late_positions_meet_up_to_the_delay_of_theory(delay, meets, capsys):
    # K lambda_N = 0.5 (2 + sqrt(2)), so the bound is pi / (2 K lambda_N) = 0.92 s
    given = {'K': 0.5, 'DELAY': delay, 'SLOW': 0.0}
    run = simulate('laplacian_consensus', 4, 80.0, graph='path', delay=delay, set=given, **THEORY)
    agreement = run.metrics()['consensus']

    assert (agreement.disagreement_at_end_m < 0.1 * agreement.disagreement_at_start_m) == meets
    assert ('oscillations grow' in capsys.readouterr().out) != meets


@pytest.mark.parametrize(('graph', 'links'), [('ring', 2), ('complete', 4)])
def test_noise_spreads_robots_as_far_as_predicted(graph, links):
    h, s, K = 0.1, 0.05, 1.0
    options = {**THEORY, 'rate': 1 / h, 'robot_rate': 1 / h, 'set': {'K': K, 'SLOW': 0.0}}
    run = simulate('laplacian_consensus', 5, 400.0, graph=graph, noise=s, **options)
    figure = run.metrics()['prediction'].figures['consensus.disagreement_rms_second_half_m']
    modes = {2: 2 - 2 * np.cos(2 * np.pi * np.arange(1, 5) / 5), 4: np.full(4, 5.0)}[links]

    squares = (h * K * s) ** 2 * links / (1 - (1 - h * K * modes) ** 2)
    assert figure.predicted == pytest.approx(np.sqrt(2 * squares.sum() / 5))
    assert figure.measured == pytest.approx(figure.predicted, rel=0.05)


@pytest.mark.parametrize(
    ('own_state', 'bound', 'words'),
    [
        ('held', 4 * 0.2 / 1.0, 'own positions as sent, too'),  # |L| c / lambda_2
        ('exact', 2 * 0.2 / 1.0, 'own positions exact'),  # |A| c / lambda_2
    ],
)
def test_events_leave_less_disagreement_than_their_bound(own_state, bound, words):
    given = {'event_triggered': True, 'threshold': 0.2, 'own_state': own_state}
    exact = {'set': {'SLOW': 0.0}, **THEORY}
    run = simulate('laplacian_consensus', 6, 60.0, graph='ring', **given, **exact)
    figure = run.metrics()['prediction'].figures['consensus.disagreement_at_end_m']
    centre = run.poses[:, :2].mean(axis=2)

    assert figure.predicted == pytest.approx(bound, rel=0.01)
    assert 0.05 * figure.predicted < figure.measured < figure.predicted
    assert words in figure.formula
    assert (np.ptp(centre, axis=0).max() < 1e-6) == (own_state == 'held')


@pytest.mark.parametrize('graph', ['path', 'star', 'directed_ring'])
def test_leaders_are_elected_within_the_diameter(graph):
    run = simulate('leader_election', 6, 5.0, graph=graph, set={'NUMBERS': [1, 2, 3, 4, 5, 6]})
    figure = run.metrics()['prediction'].figures['messages.agreement_time_s']

    assert figure.measured == pytest.approx(figure.predicted)
