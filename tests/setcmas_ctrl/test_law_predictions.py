"""Linear laws against difference equations iterated here, in plain numpy."""

import numpy as np
import pytest

from setcmas_ctrl.law_predictions import Conditions, linear_law

RING = np.roll(np.eye(6), 1, axis=1)
GRAPHS = {
    'directed ring': RING,
    'ring': RING + RING.T,
    'path': np.eye(6, k=1) + np.eye(6, k=-1),
    'complete': 1.0 - np.eye(6),
}
RATE = 'consensus.convergence_rate_1_s'


def conditions(adjacency, **others):
    starts = np.random.default_rng(1).normal(size=(3, len(adjacency)))
    return Conditions(starts, adjacency, **{'period': 0.2, **others})


def theorems(adjacency, K, given):
    """Return what is predicted of x_i' = K sum_j a_ij (x_j - x_i), the last of each metric."""
    L = np.diag(adjacency.sum(axis=1)) - adjacency
    return {one.metric: one for one in linear_law(given, K * L, 'K L', 'consensus')}


def decay_rate(adjacency, K, h=0.2, calls=2000):
    """Return the decay rate in 1/s of x_i' = K sum_j a_ij (x_j - x_i), called every h s."""
    degrees, logs = adjacency.sum(axis=1), []
    x = np.random.default_rng(0).normal(size=len(adjacency))
    for _ in range(calls):
        x = x + h * K * (adjacency @ x - degrees * x)
        x = x - x.mean()
        size = np.linalg.norm(x)
        x = x / size
        logs.append(np.log(size))
    return -np.mean(logs[calls // 2 :]) / h


@pytest.mark.parametrize('graph', GRAPHS)
def test_the_rate_is_that_of_the_iterated_equation(graph):
    rate = theorems(GRAPHS[graph], 0.3, conditions(GRAPHS[graph]))[RATE].value

    assert rate == pytest.approx(decay_rate(GRAPHS[graph], 0.3), rel=1e-3)


def test_the_slowest_mode_is_that_of_the_calls():
    complete = 1.0 - np.eye(8)
    rates = {K: theorems(complete, K, conditions(complete)) for K in (0.0625, 1.2)}

    assert rates[0.0625][RATE].value == pytest.approx(0.527, abs=1e-3)  # -ln(1 - 0.2 * 0.5)/0.2
    assert rates[1.2][RATE].value == pytest.approx(0.417, abs=1e-3)
    assert decay_rate(complete, 1.2) == pytest.approx(0.417, abs=1e-3)
    found = linear_law(conditions(complete), 1.2 * (8 * np.eye(8) - 1.0), 'K L')
    assert 'lambda_2 of K L' not in [
        one.formula for one in found
    ]  # 9.6 1/s is far from what calls every 0.2 s do


def test_a_graph_in_two_parts_has_no_slowest_mode():
    two = np.kron(np.eye(2), 1.0 - np.eye(3))

    assert theorems(two, 0.2, conditions(two)) == {}


@pytest.mark.parametrize('graph', ['directed ring', 'path'])
def test_robots_meet_where_the_equation_ends(graph):
    adjacency, K, h = GRAPHS[graph].copy(), 0.2, 0.2
    adjacency[0] *= 2.0  # not balanced
    given = conditions(adjacency)
    x = given.starts[0]
    for _ in range(3000):
        x = x + h * K * (adjacency @ x - adjacency.sum(axis=1) * x)

    assert np.ptp(x) < 1e-6
    found = theorems(adjacency, K, given)['consensus.final_centre_x_m']
    assert found.value == pytest.approx(x[0], abs=1e-6)
