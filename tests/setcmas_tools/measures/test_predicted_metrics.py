"""Predictions next to metrics, of runs that do as predicted."""

from dataclasses import replace

import numpy as np
import pytest

from setcmas_ctrl.laws.script_loader import ALGORITHMS
from setcmas_tools import Run, simulate
from setcmas_tools.measures import predicted_metrics
from setcmas_tools.measures.metrics import as_dict, theory_lines
from setcmas_tools.measures.predicted_metrics import Conditions, linear_law

THEORY = {'model': 'omnidirectional', 'vnom': 50.0, 'rate': 25.0, 'robot_rate': 25.0}
RATE = 'consensus.convergence_rate_1_s'


@pytest.mark.parametrize(
    ('graph', 'nb_robots'),
    [('complete', 8), ('star', 8), ('ring', 8), ('directed_ring', 8), ('path', 4)],
)
def test_robots_of_the_theory_meet_as_fast_and_where_the_law_predicts(graph, nb_robots):
    run = simulate('consensus', nb_robots, 40.0, graph=graph, **THEORY)
    found = run.metrics()['prediction']
    theorem, sampled = [one for one in found.figures if one.metric == RATE]

    name = 'lambda_2' if graph in ('complete', 'ring') else 'least Re lambda'
    assert theorem.formula == f'{name} of K inv(I + D) L'
    assert sampled.measured == pytest.approx(sampled.predicted, rel=0.07)  # faster modes add
    for name in ('x', 'y'):
        centre = found.figure(f'consensus.final_centre_{name}_m')
        assert centre.measured == pytest.approx(centre.predicted, abs=0.01)
    assert {note.partition(' (from')[0] for note in found['left_out']} <= {'robots at rest'}


def test_what_the_theory_leaves_out_is_said():
    run = simulate('consensus', 4, 20.0, graph='ring', loss=0.5, filter='barrier')
    last = run.metrics()['prediction'].lines[-1]

    for note in (
        'turning before driving', 'the speed limit (reached until', 'lost messages (',
        'the safety filter',
    ):  # fmt: skip
        assert note in last
    assert 'noise' not in last


@pytest.mark.parametrize(
    ('law', 'options'),
    [
        ('leader_election', {'graph': 'path', 'loss': 0.3}),
        ('leader_election', {'rate': 20.0, 'robot_rate': 10.0}),
        ('coverage', {}),
    ],
)
def test_laws_without_theory_have_no_prediction(law, options):
    assert 'prediction' not in simulate(law, 4, 3.0, **options).metrics()


@pytest.mark.parametrize(
    ('K', 'rate', 'formulas'),
    [
        (0.0625, 0.527, ['lambda_2 of K L', 'sampled model, h = 0.2 s: -ln(rho)/h']),
        (1.2, 0.417, ['sampled model, h = 0.2 s: -ln(rho)/h']),  # calls are too rare for 9.6 1/s
    ],
)
def test_the_slowest_mode_is_that_of_the_calls(K, rate, formulas):
    given = Conditions(np.zeros((3, 8)), 1.0 - np.eye(8), period=0.2)
    rates = [one for one in linear_law(given, K * given.laplacian, 'K L') if one.metric == RATE]

    assert rates[-1].predicted == pytest.approx(rate, abs=1e-3)  # -ln |1 - 0.2 * 8 K| / 0.2
    assert [one.formula for one in rates] == formulas


def test_a_graph_in_two_parts_has_no_slowest_mode():
    two = Conditions(np.zeros((3, 6)), np.kron(np.eye(2), 1.0 - np.eye(3)), period=0.2)

    assert linear_law(two, 0.2 * two.laplacian, 'K L') == []


def test_robots_start_where_they_were_at_the_first_command():
    run = simulate('laplacian_consensus', 4, 5.0)
    earlier = replace(run.table, t=run.table.t - 0.03)  # as over ROS: none is of t = 0
    figures = replace(run, table=earlier).metrics()['prediction']

    assert figures.figure('consensus.final_centre_x_m').predicted == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize('options', [{'delay': 0.3}, {'set': {'DELAY': 0.4}}])
def test_late_positions_are_not_predicted(options):
    metrics = simulate('laplacian_consensus', 4, 5.0, **options).metrics()

    assert theory_lines(metrics) == ['theory: the law predicts nothing for these conditions']


def test_robots_that_have_met_do_not_rest_because_of_a_dead_band():
    exact = THEORY | {'vnom': 0.5, 'set': {'K': 12.5, 'SLOW': 0.0}}  # they meet at the first call
    run = simulate('laplacian_consensus', poses=[[0, 0.01], [0, 0], [0, 0]], nb_robots=2, **exact)

    assert run.metrics()['prediction']['left_out'] == ['robots at rest (from 0.0 s)']


def test_a_stored_copy_of_a_law_predicts_and_a_changed_one_does_not(tmp_path):
    text = ALGORITHMS.file('consensus').read_text()
    for name, content in {'same': text, 'changed': text + '\n'}.items():
        (tmp_path / f'{name}.py').write_text(content)
        run = simulate(str(tmp_path / f'{name}.py'), 3, 20.0, set={'K': 0.3})
        stored = Run.load(run.save(tmp_path / name))
        assert ('prediction' in stored.metrics()) == (name == 'same')
        assert str(stored.metrics()) == str(run.metrics())


def test_predicted_values_are_written():
    metrics = simulate('laplacian_consensus', 4, 5.0).metrics()
    figure = metrics['prediction'].figure(RATE)

    assert as_dict(metrics)['prediction']['consensus_convergence_rate_1_s'] == pytest.approx(
        figure.predicted, rel=1e-5
    )
    line = f'theory: convergence rate {figure.predicted:.3g} 1/s (sampled model, h = 0.2 s: '
    assert line in '\n'.join(theory_lines(metrics))


def test_a_prediction_that_fails_is_reported(monkeypatch, capsys):
    monkeypatch.setitem(predicted_metrics.PREDICTIONS, 'consensus', lambda law, _: law.missing)

    assert 'prediction' not in simulate('consensus', 3, 5.0).metrics()
    assert 'prediction failed: AttributeError: ' in capsys.readouterr().out
