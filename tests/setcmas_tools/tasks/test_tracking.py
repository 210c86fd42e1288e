import math

import numpy as np
import pytest
from metrics_runs import T, table
from runs import measure

from setcmas_ctrl.task.references import References


def test_tracking_errors():
    radius = np.where(T < 10, 2.5, 2.1)
    fleet = table((T, radius * np.cos(0.2 * T), radius * np.sin(0.2 * T)))

    references = References('tracking', {'R': 2.0, 'W': 0.2})
    errors = measure(fleet, references=references)['tracking']

    whole = math.sqrt((100 * 0.5**2 + 101 * 0.1**2) / 201)
    assert errors.tracking_error_rms_m == pytest.approx({1: whole})
    assert errors.tracking_error_rms_second_half_m == pytest.approx({1: 0.1})
    assert errors.fleet_tracking_error_rms_m == pytest.approx(whole)
