import math

import pytest
from metrics_runs import T, table
from runs import measure

from setcmas_ctrl.task.references import References


def test_distance_errors_of_a_formation():
    fleet = table((T, 0, 0), (T, 3, 0), (T, 0, 4))

    errors = measure(fleet, references=References('distances', {'D': 3.0}))['distances']

    assert errors.distance_errors_final_m == pytest.approx({'1-2': 0.0, '1-3': 1.0, '2-3': 2.0})
    assert errors.distance_error_final_rms_m == pytest.approx(math.sqrt(5 / 3))
    assert errors.distance_error_rms_last_quarter_m == pytest.approx(math.sqrt(5 / 3))
    assert errors.distance_error_final_largest_m == pytest.approx(2.0)
