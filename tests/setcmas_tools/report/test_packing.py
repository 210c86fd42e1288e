import math

import numpy as np
from report_pages import unpacked

from setcmas_tools.report.packing import SCALE, changes, packed


def test_numbers_come_back_to_a_tenth_of_a_millimetre_and_gaps_stay():
    values = np.cumsum(np.random.default_rng(1).normal(size=500))
    values[[0, 17, 18, 499]] = math.nan

    assert np.allclose(unpacked(packed(values)), values, rtol=0, atol=0.6 / SCALE, equal_nan=True)
    assert packed([]) == []
    assert packed([math.nan]) == [None]


def test_what_seldom_changes_is_told_where_it_does():
    assert changes(['a', 'a', 'b', 'b', 'a']) == [(0, 'a'), (2, 'b'), (4, 'a')]
    assert changes([]) == []
