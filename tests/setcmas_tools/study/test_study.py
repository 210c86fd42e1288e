import math

import numpy as np
import pytest

from setcmas_tools.study.study import median, quantiles

INF, NAN = math.inf, math.nan


@pytest.mark.parametrize(
    ('values', 'middle'),
    [
        ([3, 1, NAN], 2),
        ([3, 1, 8], 3),
        ([1, 2, 4, INF], 3),
        ([1, 2, INF, INF], INF),
        ([1, INF, INF, INF], INF),
    ],
)
def test_the_median_is_the_midpoint_unless_that_is_never_reached(values, middle):
    assert median(np.array(values)) == middle


def test_a_band_holds_its_share_of_the_values():
    values = np.arange(1.0, 21.0)

    assert quantiles(values, 0.05, 0.95).tolist() == [1.5, 19.5]
    assert np.isnan(quantiles(values[:0], 0.5)).all()
