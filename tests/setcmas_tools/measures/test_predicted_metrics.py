from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from setcmas_ctrl.control.prediction import LinearLaw, Predicted, RunConditions
from setcmas_ctrl.scripts.loader import ALGORITHMS
from setcmas_tools import Run, simulate
from setcmas_tools.measures import predicted_metrics
from setcmas_tools.measures.metrics import as_dict

THEORY = {'model': 'omnidirectional', 'vnom': 50.0, 'rate': 25.0, 'robot_rate': 25.0}
RATE = 'consensus.convergence_rate_1_s'


@pytest.mark.parametrize(
    ('graph', 'nb_robots', 'slowest'),
    [
        ('complete', 8, 0.5),
        ('star', 8, 0.25),
        ('ring', 8, 0.0976),
        ('directed_ring', 8, 0.0732),
        ('path', 4, 0.136),
    ],
)
def test_robots_of_the_theory_meet_as_fast_and_where_the_law_predicts(graph, nb_robots, slowest):
    run = simulate('consensus', nb_robots, 40.0, graph=graph, **THEORY)
    comparison = run.metrics()['prediction']
    rate = comparison.figures[RATE]

    assert rate.measured == pytest.approx(rate.predicted, rel=0.01)
    assert f'slowest mode {slowest:.3g} 1/s' in rate.formula
    for name in ('x', 'y'):
        centre = comparison.figures[f'consensus.final_centre_{name}_m']
        assert centre.measured == pytest.approx(centre.predicted, abs=0.01)
    assert {note.partition(' (from')[0] for note in comparison.differs} <= {'robots at rest'}


def test_what_the_theory_leaves_out_is_said():
    run = simulate('consensus', 4, 20.0, graph='ring', loss=0.5, delay=0.1, filter='barrier')
    lines = '\n'.join(run.metrics()['prediction'].lines())

    for note in (
        'turning before driving', 'the speed limit (reached until', 'lost messages',
        'the safety filter',
    ):  # fmt: skip
        assert note in lines
    assert 'noise' not in lines
    assert 'received positions 0.1 s old' in lines


def test_links_with_properties_of_their_own_are_left_out(tmp_path):
    (tmp_path / 'graph.yaml').write_text('edges: [1 - 2]\nlinks: [{link: 1 <- 2, delay: 1}]\n')
    options = {'graph': str(tmp_path / 'graph.yaml'), 'set': {'SLOW': 0.0}, **THEORY}
    one_way = simulate('laplacian_consensus', 2, 20.0, **options).metrics()['prediction']
    (tmp_path / 'graph.yaml').write_text(
        'edges: [1 - 2]\nlinks: [{link: 1 <- 2, delay: 1}, {link: 2 <- 1, delay: 1}]\n'
    )
    both = simulate('laplacian_consensus', 2, 20.0, **options).metrics()['prediction']

    assert one_way.differs == ('delay of messages',)
    assert both.differs == ()
    assert both.figures['distance_from_predicted_end_m'].measured < 1e-6


def test_robots_that_have_met_do_not_rest_because_of_a_dead_band():
    exact = THEORY | {'vnom': 0.5, 'set': {'K': 12.5, 'SLOW': 0.0}}  # they meet at the first call
    run = simulate('laplacian_consensus', poses=[[0, 0.01], [0, 0], [0, 0]], nb_robots=2, **exact)

    assert run.metrics()['prediction'].differs == ('robots at rest (from 0.0 s)',)


def test_a_stored_copy_of_a_law_predicts_and_a_changed_one_does_not(tmp_path):
    text = ALGORITHMS.file('consensus').read_text()
    for name, content in {'same': text, 'changed': text + '\n'}.items():
        (tmp_path / f'{name}.py').write_text(content)
        run = simulate(str(tmp_path / f'{name}.py'), 3, 20.0, set={'K': 0.3})
        stored = Run.load(run.save(tmp_path / name))
        assert ('prediction' in stored.metrics()) == (name == 'same')
        assert str(stored.metrics()) == str(run.metrics())


def test_the_distance_from_the_predicted_end_is_written_as_measured():
    metrics = simulate('consensus', 4, 5.0).metrics()
    figure = metrics['prediction'].figures['distance_from_predicted_end_m']

    assert figure.measured > 0.1  # unicycles turn first
    written = as_dict(metrics)['prediction']['distance_from_predicted_end_m']
    assert written == pytest.approx(figure.measured, rel=1e-5)
    assert f'  distance from predicted end {figure.measured:.3g} m' in str(metrics).splitlines()


def test_a_law_without_predictions_has_none():
    assert 'prediction' not in simulate('nav_wp', 2, 5.0).metrics()


@pytest.mark.parametrize('changes', [False, True])
def test_robots_that_cannot_meet_are_doubted_unless_the_graph_changes(tmp_path, capsys, changes):
    later = '  - {edges: [1 - 2, 2 - 3], duration: 1}\n' if changes else ''
    graph = tmp_path / 'graph.yaml'
    graph.write_text(f'segments:\n  - {{edges: [1 - 2], duration: 1}}\n{later}')
    run = simulate('laplacian_consensus', 3, 5.0, graph=str(graph))

    doubt = 'the graph at the start has no directed spanning tree; unless it changes, the robots'
    assert capsys.readouterr().out.count(doubt) == 1
    assert (doubt in str(run.metrics())) == (not changes)


@pytest.mark.parametrize('rate', [1e9, float('inf'), float('nan'), -1.0])
def test_a_rate_that_would_take_hours_is_not_followed(rate):
    run = simulate('consensus', 3, 2.0)
    claimed = replace(run, info=replace(run.info, scenario={**run.info.scenario, 'rate': rate}))

    assert 'prediction' in run.metrics()
    assert 'prediction' not in claimed.metrics()


@pytest.mark.parametrize('settings', [{'UNKNOWN': 1.0}, {'K': 'fast'}, {3: 4}, 'K=1', [1]])
def test_settings_that_do_not_fit_cost_the_prediction_only(capsys, settings):
    run = simulate('consensus', 3, 2.0)
    changed = replace(run, info=replace(run.info, scenario={**run.info.scenario, 'set': settings}))

    assert set(changed.metrics()) == set(run.metrics()) - {'prediction'}
    assert capsys.readouterr().out.count('prediction skipped: ') == 1


def test_values_of_a_nonlinear_law(monkeypatch):
    def predict(conditions):
        assert conditions.starts.shape == (3, 3)
        return {'separation.least_separation_m': Predicted(0.5, 'd / 2')}

    law = SimpleNamespace(predict=predict)
    monkeypatch.setattr(predicted_metrics, '_law', lambda _: (law, 'mine'))
    metrics = simulate('consensus', 3, 5.0).metrics()

    assert metrics['prediction'].lines()[0] == 'predicted by d / 2:'
    assert metrics['prediction'].lines()[1].startswith('  least separation ')
    assert metrics['prediction'].lines()[1].endswith(' m, predicted 0.5')
    assert as_dict(metrics)['prediction']['separation_least_separation_m'] == 0.5


@pytest.mark.parametrize('result', [3, {RATE: 0.5}])
def test_another_result_is_reported(monkeypatch, capsys, result):
    law = SimpleNamespace(predict=lambda _: result)
    monkeypatch.setattr(predicted_metrics, '_law', lambda _: (law, 'mine'))

    assert 'prediction' not in simulate('consensus', 3, 5.0).metrics()
    assert 'predict of mine must return a LinearLaw or values Predicted' in capsys.readouterr().out


def test_a_formation_predicts_its_rate_only():
    starts = np.array([[0.0, 1.0, 3.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.0]])
    adjacency = 1.0 - np.eye(3)
    conditions = RunConditions(starts, adjacency, period=0.1, duration=3.0)
    offsets = np.array([[0.0, 1.0, 2.0], [0.0, 0.0, 0.0]])
    law = LinearLaw(0.2 * conditions.laplacian, 'K L', offsets)
    t, positions = law.positions(conditions)

    assert t[-1] == pytest.approx(3.0)
    assert positions.shape == (31, 2, 3)
    centred = positions - offsets
    assert np.allclose(centred[-1].mean(axis=1), centred[0].mean(axis=1))
    assert law.slowest_rate == pytest.approx(0.6)
