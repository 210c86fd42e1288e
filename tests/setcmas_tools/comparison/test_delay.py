import numpy as np
import pytest

from setcmas_tools.comparison.delay import delay_of

T = np.arange(300) / 10


def speeds(delay, noise=0.0):
    """Speed and turn rate of a robot that does the same later, in s."""
    t = np.maximum(T - delay, 0.0)
    wrong = np.random.default_rng(1).normal(0.0, noise, (2, len(T)))
    return np.array([0.1 + 0.1 * np.sin(0.3 * t**1.3), np.cos(0.2 * t**1.4)]) + wrong


@pytest.mark.parametrize('delay', [0.0, 0.4, 6.1])
def test_a_delay_is_found_under_noise_and_with_gaps(delay):
    measured = speeds(delay, noise=0.02)
    measured[:, 40:45] = np.nan

    assert delay_of(speeds(0.0), measured) == pytest.approx(delay)
    assert delay_of(measured, speeds(0.0)) == pytest.approx(-delay)


def test_speeds_that_are_not_alike_or_do_not_change_have_no_delay():
    noise = np.random.default_rng(2).normal(size=(2, 300))
    assert delay_of(speeds(0.0), noise) is None
    assert delay_of(speeds(0.0), np.zeros((2, 300))) is None
    assert delay_of(speeds(0.0), np.zeros((2, 1))) is None
