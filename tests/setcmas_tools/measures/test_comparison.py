from dataclasses import replace

import numpy as np
import pytest
from metrics_runs import T, table
from runs import run_of

from setcmas_simu.errors import SetcmasError
from setcmas_tools import simulate
from setcmas_tools.measures.comparison import best_shift, differences, distances_between
from setcmas_tools.run.run_info import Outcome, RunInfo, RunState
from setcmas_tools.run.run_records import SafetyRecord


def wave(delay, offset=0.0):
    """Two robots on a curve, which begin their way after a delay in s."""
    on_way = np.maximum(T - delay, 0.0)
    x, y = 0.3 * on_way, np.sin(0.5 * on_way)
    return run_of(table((T, x, y, 0.3), (T, -x, y + offset, 0.3)))


@pytest.mark.parametrize('delay', [0.0, 0.7, 3.2])
def test_a_delay_is_found_and_taken_out(delay):
    apart = best_shift(wave(0.0), wave(delay, offset=0.1))

    assert apart.shift == pytest.approx(delay)
    assert apart.rms == pytest.approx({1: 0.0, 2: 0.1}, abs=1e-9)
    assert best_shift(wave(delay), wave(0.0)).shift == pytest.approx(-delay)
    assert 'at most 0.1 m (tb3_2 at' in str(apart)


def test_two_simulations_are_compared_at_the_same_times():
    slow, fast = (simulate('consensus', 2, 20, set={'K': K}) for K in (0.3, 0.6))
    found = best_shift(slow, fast)

    assert found.shift == 0.0
    assert str(found).startswith('is 0.')
    t, distances = distances_between(slow, fast)
    np.testing.assert_allclose(t, found.t)
    np.testing.assert_allclose(distances[1], found.distances[1])


def test_runs_without_a_common_robot_are_refused():
    other = run_of(table((T, T, 0)))
    alone = run_of(table((T, T, 0)).rows(np.zeros(0, int)))
    assert best_shift(other, other).rms == {1: 0.0}
    with pytest.raises(SetcmasError, match='no robot is in both runs'):
        best_shift(other, alone)


@pytest.fixture(scope='session')
def run():
    return simulate('consensus', 3, 3.0)


def test_a_law_that_failed_is_reported(run):
    failed = Outcome(RunState.FAILED, {'law.py': [1, 2]})
    other = replace(run, info=replace(run.info, outcome=failed))

    assert [*differences(run, other)] == [
        'outcome: complete -> complete, but law.py failed for robots 1-2'
    ]


def test_a_run_without_a_description_is_reported_in_a_line(run):
    other = replace(run, info=RunInfo(), inputs=())

    assert [*differences(run, other)] == ['options and versions of this run are not known']


def test_an_experiment_and_a_simulation_differ_in_options_that_both_have(run):
    own = {'vnom': 0.2, 'algo': run.parameters['algo'], 'limits.V_max': 0.21}
    info = replace(run.info, scenario=own)
    safety = SafetyRecord.in_order([0.0], [1], ['moving'], [False])
    lab = replace(run, info=info, safety=safety)

    assert [*differences(lab, run)] == [
        'kind: experiment -> simulation; what only one of them has is left out',
        'vnom: 0.2 -> 0.5',
    ]
