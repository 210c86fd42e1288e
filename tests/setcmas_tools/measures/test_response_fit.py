from dataclasses import replace

import numpy as np
import pytest

from setcmas_simu.robots.identified_robot import Response
from setcmas_tools.measures.response_fit import MeasuredSpeeds, fitted

RATE_HZ = 50.0


def measured(response, changes, noise=0.0, seconds=40.0, seed=1):
    """Return windows of 0.2 s of a speed that answers random steps, from its own integration."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, seconds / changes) + 0.1
    u = rng.uniform(-0.2, 0.2, len(t)) if changes > 1 else np.array([0.2])
    fine = np.arange(0.0, seconds, 1e-3)
    sent = np.where(
        fine - response.delay < t[0],
        0.0,
        u[np.searchsorted(t, fine - response.delay, side='right') - 1],
    )
    w = np.zeros(len(fine))
    for k in range(1, len(fine)):
        w[k] = w[k - 1] + 1e-3 / response.lag * (response.gain * sent[k - 1] - w[k - 1])
    way = np.concatenate([[0.0], np.cumsum(w[:-1]) * 1e-3])
    begin = np.arange(0.0, seconds - 0.3, 1.0 / RATE_HZ)
    end = begin + 0.2
    moved = np.interp(end, fine, way) - np.interp(begin, fine, way)
    y = moved / 0.2 + rng.normal(0.0, noise, len(begin))
    return MeasuredSpeeds(t, u, begin, end, y, 10.0)


@pytest.mark.parametrize(
    'response', [Response(0.9, 0.15, 0.2), Response(1.1, 0.4, 0.05), Response(0.8, 0.05, 0.6)]
)
@pytest.mark.parametrize('noise', [0.0, 0.01])
def test_gain_lag_and_delay_are_found(response, noise):
    found = fitted(measured(response, changes=40, noise=noise))

    assert found.times_known
    assert found.response.gain == pytest.approx(response.gain, rel=0.02)
    assert found.response.lag == pytest.approx(response.lag, rel=0.05, abs=0.005)
    assert found.response.delay == pytest.approx(response.delay, rel=0.05, abs=0.005)
    assert found.quality > 85.0


def test_standard_errors_grow_with_noise_and_hold_the_truth():
    truth = Response(0.9, 0.15, 0.2)
    quiet, loud = (fitted(measured(truth, 40, noise)) for noise in (0.002, 0.02))

    assert quiet.errors.lag < loud.errors.lag
    for one in (quiet, loud):
        assert abs(one.response.lag - truth.lag) < 4 * one.errors.lag + 2e-3
        assert abs(one.response.delay - truth.delay) < 4 * one.errors.delay + 2e-3


def test_standard_errors_hold_the_truth_of_a_gain_that_differs_between_manoeuvres():
    held = 0
    for seed in range(20):
        steady = measured(Response(1.0, 0.1, 0.0), 40, seed=seed)
        gains = np.random.default_rng(seed).normal(1.0, 0.1, 40)[steady.begin.astype(int)]
        found = fitted(replace(steady, y=steady.y * gains))
        held += abs(found.response.gain - 1.0) <= 2 * found.errors.gain

    assert held >= 17


def test_a_robot_that_stands_or_ignores_commands_gives_no_values():
    standing = measured(Response(0.9, 0.15, 0.2), 40)
    noise = np.random.default_rng(2).normal(0.0, 0.05, len(standing.y))
    ignoring = replace(standing, y=noise)
    unmoved = replace(ignoring, t=np.array([0.0, 1.0]), u=np.zeros(2))

    assert not fitted(ignoring).gain_known
    assert not fitted(unmoved).gain_known


def test_a_constant_command_gives_neither_lag_nor_delay():
    constant = measured(Response(0.9, 0.15, 0.2), changes=1, noise=0.05)
    late = constant.begin > 2.0
    alone = replace(
        constant, begin=constant.begin[late], end=constant.end[late], y=constant.y[late]
    )

    found = fitted(alone)

    assert not found.times_known


def test_a_robot_that_follows_at_once_has_no_lag():
    """Its lag and delay cannot be distinguished, but their sum is known."""
    found = fitted(measured(Response(1.0, 1e-3, 0.0), changes=40, noise=0.01))

    assert found.times_known
    assert found.response.lag + found.response.delay < 0.01
    assert found.errors.delay < 0.02


@pytest.mark.parametrize('early', [0.02, 0.05, 0.09])
def test_gain_of_a_simulation_that_holds_a_command_for_its_whole_step(early):
    t = np.arange(0.0, 20.0, 0.2)
    u = -3.5 * np.exp(-1.5 * t)
    steps = np.arange(-1.0, 20.0, 0.1) + 0.1 - early  # each with the command of its end
    held = np.searchsorted(t, steps + 1e-9, side='right') - 1
    way = np.cumsum(np.where(held < 0, 0.0, 0.1 * u[held]))
    begin, end = steps[:-2], steps[2:]
    y = (way[2:] - way[:-2]) / (end - begin)

    found = fitted(MeasuredSpeeds(t, u, begin, end, y, 2.0))

    assert found.response.gain == pytest.approx(1.0, abs=0.002)
    assert found.response.delay == 0.0
    assert found.errors.delay == pytest.approx(early, abs=0.03)
    assert found.times_known
