import numpy as np
import pytest
from trajectory_comparison import compare

T = np.arange(0, 20, 0.1)


def circle(t, radius=2.0):
    return radius * np.array([np.cos(0.2 * t), np.sin(0.2 * t)])


@pytest.mark.parametrize('shift', [0.0, 0.237, -0.5])
def test_a_shift_in_time_is_removed(shift):
    result = compare(T, circle(T), T - shift, circle(T))

    assert result.rms < 1e-3
    assert result.shift == pytest.approx(shift, abs=1e-3)


def test_no_more_than_the_largest_shift_is_removed():
    result = compare(T, circle(T), T - 1.0, circle(T), max_shift=0.5)

    assert result.shift == pytest.approx(0.5)
    assert result.rms == pytest.approx(0.5 * 0.4, rel=0.01)


def test_a_distance_in_space_is_not():
    assert compare(T, circle(T), T, circle(T, 2.3)).rms == pytest.approx(0.3, abs=1e-3)


def test_only_common_times_count():
    later = T[100:]

    assert compare(T, circle(T), later, circle(later)).rms < 1e-3


def test_trajectories_that_never_overlap():
    with pytest.raises(ValueError, match='overlap'):
        compare(T, circle(T), T + 100, circle(T))
