import numpy as np
import pytest
from metrics_runs import T, table
from runs import measure

from setcmas_ctrl.laws.references import References, checked_references
from setcmas_simu.errors import SetcmasError

BOX = References('coverage', {'BOX': [[-1, -2], [3, 2]]})


def test_the_cost_of_a_robot_is_the_second_moment_of_the_box():
    still = measure(table((T, 1, 0)), references=BOX)['coverage']
    away = measure(table((T, 1 + 0.1 * T, 0)), references=BOX)['coverage']

    assert still.cost_at_start_m4 == pytest.approx(16 * (16 + 16) / 12, rel=1e-3)
    assert still.largest_rise_percent == 0.0
    assert away.cost_at_end_m4 == pytest.approx(16 * (32 / 12 + 4), rel=1e-3)
    assert away.largest_rise_percent == pytest.approx(150, abs=0.2)


def test_a_robot_that_is_missing_at_times_costs_nothing_then():
    two = measure(table((T, 0, 0), (T[:100], 2, 0)), references=BOX)['coverage']

    assert two.cost_at_end_m4 == two.cost_at_start_m4 == pytest.approx(16 * 20 / 12, rel=1e-3)
    assert 'coverage' not in measure(table((T, 0, np.nan)), references=BOX)


@pytest.mark.parametrize(
    'box', [3, [[0, 0]], [[0, 0], [1, 0]], [[1, 1], [0, 0]], [[0, 0], [1e200, 1]]]
)
def test_a_box_has_two_corners(box):
    with pytest.raises(SetcmasError, match=r'BOX is .*must be'):
        checked_references('coverage', {'BOX': box}, 'law.py')
