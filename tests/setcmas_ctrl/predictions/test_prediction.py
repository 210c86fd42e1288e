"""Linear laws against difference equations iterated here, in plain numpy."""

import numpy as np
import pytest

from setcmas_ctrl.predictions.prediction import Conditions, Departure, LinearLaw

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


def laplacian_law(adjacency, K, own_delay=0.0):
    L = np.diag(adjacency.sum(axis=1)) - adjacency
    return LinearLaw(K * L, 'K L', 'consensus', own_delay=own_delay)


def theorems(law, given):
    return {one.metric: one for one in law.theorems(given)}


def growth(adjacency, K, own_delay, delay, h=0.2, calls=2000):
    """Return the factor per call of the motion of x_i' = K sum_j a_ij (x_j - x_i).

    Own positions and those of others are late by whole periods.
    """
    own, other = round(own_delay / h), round(delay / h)
    degrees, logs, scale = adjacency.sum(axis=1), [], 0.0
    x = np.random.default_rng(0).normal(size=(max(own, other) + 2, len(adjacency)))
    for _ in range(calls):
        new = x[-1] + h * K * (adjacency @ x[-1 - other] - degrees * x[-1 - own])
        x = np.vstack([x[1:], new]) - new.mean()
        size = np.linalg.norm(np.diff(x, axis=0))
        x, scale = x / size, scale + np.log(size)
        logs.append(scale)
    return np.exp((logs[-1] - logs[calls // 2]) / (calls - 1 - calls // 2))


@pytest.mark.parametrize('graph', GRAPHS)
@pytest.mark.parametrize(('own_delay', 'delay'), [(0.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.4, 1.0)])
def test_the_slowest_factor_is_that_of_the_iterated_equation(graph, own_delay, delay):
    adjacency = GRAPHS[graph]
    law = laplacian_law(adjacency, 0.3, own_delay)
    factor = law.slowest_factor(conditions(adjacency, delay=delay))

    assert abs(factor) == pytest.approx(growth(adjacency, 0.3, own_delay, delay), rel=1e-3)


def test_the_slowest_mode_is_that_of_the_calls():
    complete = 1.0 - np.eye(8)
    rates = {K: theorems(laplacian_law(complete, K), conditions(complete)) for K in (0.0625, 1.2)}

    assert rates[0.0625][RATE].value == pytest.approx(0.527, abs=1e-3)  # -ln(1 - 0.2 * 0.5)/0.2
    assert rates[1.2][RATE].value == pytest.approx(0.417, abs=1e-3)
    assert -np.log(growth(complete, 1.2, 0.0, 0.0)) / 0.2 == pytest.approx(0.417, abs=1e-3)
    formulas = [one.formula for one in laplacian_law(complete, 1.2).theorems(conditions(complete))]
    assert 'lambda_2 of K L' not in formulas  # 9.6 1/s is far from what calls every 0.2 s do


def test_a_graph_in_two_parts_has_no_slowest_mode():
    two = np.kron(np.eye(2), 1.0 - np.eye(3))
    law = laplacian_law(two, 0.2)

    assert list(law.theorems(conditions(two))) == []


@pytest.mark.parametrize('graph', ['directed ring', 'path'])
@pytest.mark.parametrize(('own_delay', 'delay'), [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0)])
def test_robots_meet_where_the_equation_ends(graph, own_delay, delay):
    adjacency, K, h = GRAPHS[graph].copy(), 0.2, 0.2
    adjacency[0] *= 2.0  # not balanced, or not equal degrees
    given = conditions(adjacency, delay=delay)
    found = theorems(laplacian_law(adjacency, K, own_delay), given)
    x = [given.starts[0]] * 6
    for _ in range(3000):
        pull = adjacency @ x[-1 - round(delay / h)]
        pull -= adjacency.sum(axis=1) * x[-1 - round(own_delay / h)]
        x = [*x[1:], x[-1] + h * K * pull]

    assert np.ptp(x[-1]) < 1e-6
    assert found['consensus.final_centre_x_m'].value == pytest.approx(x[-1][0], abs=1e-6)


def test_the_bound_of_events_holds_for_errors_up_to_the_threshold():
    ring, K, h, c = GRAPHS['ring'], 0.2, 0.04, 0.2
    given = conditions(ring, period=h, duration=60.0, threshold=c)
    bound = theorems(laplacian_law(ring, K), given)['consensus.disagreement_at_end_m']
    L = np.diag(ring.sum(axis=1)) - ring
    worst = c * np.linalg.eigh(L)[1][:, 1] * np.sqrt(6)  # an error along the slowest mode
    x = given.starts[:2].copy()
    for _ in range(round(60.0 / h)):
        x = x - h * K * (x + np.clip(worst, -c, c) / np.sqrt(2)) @ L

    apart = np.sqrt(np.mean(np.sum((x - x.mean(axis=1)[:, None]) ** 2, axis=0)))
    assert bound.value == pytest.approx(4 * c / 1.0, rel=0.01)  # |L| c / lambda_2
    assert apart < bound.value
    assert bound.excludes == {*Departure} - {Departure.EVENTS}
