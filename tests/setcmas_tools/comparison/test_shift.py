import numpy as np
import pytest
from metrics_runs import T, table
from runs import run_of

from setcmas_simu.errors import SetcmasError
from setcmas_tools.comparison.shift import best_shift


def wave(delay, offset=0.0):
    """Two robots on a curve, which begin their way after a delay in s."""
    on_way = np.maximum(T - delay, 0.0)
    x, y = 0.3 * on_way, np.sin(0.5 * on_way)
    return run_of(table((T, x, y, 0.3), (T, -x, y + offset, 0.3)))


@pytest.mark.parametrize('delay', [0.0, 0.7, 3.2])
def test_a_delay_is_found_and_taken_out(delay):
    beside = best_shift(wave(0.0), wave(delay, offset=0.1))

    assert beside.shift == pytest.approx(delay)
    assert beside.rms == pytest.approx({1: 0.0, 2: 0.1}, abs=1e-9)
    assert best_shift(wave(delay), wave(0.0)).shift == pytest.approx(-delay)
    assert 'at most 0.1 m (tb3_2 at' in str(beside)


def test_runs_without_a_common_robot_are_refused():
    other = run_of(table((T, T, 0)))
    alone = run_of(table((T, T, 0)).rows(np.zeros(0, int)))
    assert best_shift(other, other).rms == {1: 0.0}
    with pytest.raises(SetcmasError, match='no robot is in both runs'):
        best_shift(other, alone)
