"""Resets: a robot is put somewhere else, and nothing of that is driven."""

import numpy as np
import pytest
from runs import measure

from setcmas_tools.records.fleet_grid import on_grid
from setcmas_tools.records.fleet_table import fleet_table
from setcmas_tools.records.gaps import resets

T = np.arange(0, 10, 0.1)


def driven(x, v=0.5):
    columns = np.broadcast_arrays(T, 1, x, 0.0, 0.0, v, 0.0)
    return fleet_table(np.transpose(columns))


@pytest.fixture
def put_back():
    """A robot at 0.5 m/s that is put back to its start after 5 s."""
    return driven(np.where(T < 5, 0.5 * T, 0.5 * (T - 5)))


def test_a_reset_is_no_way(put_back):
    motion = measure(put_back)['robots'][1]

    assert np.flatnonzero(resets(put_back)) == [np.searchsorted(T, 4.95) - 1]
    assert motion.path_length_m == pytest.approx(4.9)
    assert motion.mean_speed_m_s <= motion.largest_speed_m_s


@pytest.mark.parametrize('rate', [25.0, 10.0, 2.0])
def test_no_line_joins_what_is_before_a_reset_and_after(put_back, rate):
    steps = np.diff(on_grid(put_back, rate).x[0])

    assert np.nanmin(steps) > 0
    assert np.nanmax(steps) == pytest.approx(0.5 / rate)


def test_what_could_have_been_driven_is_no_reset():
    noise = 0.02 * np.random.default_rng(0).normal(size=len(T))
    assert not resets(driven(0.5 * T + noise)).any()
    assert not resets(driven(3 * T, v=3.0)).any()
    assert not resets(driven(50 * T, v=0.0)).any()  # its odometry tells no speed
