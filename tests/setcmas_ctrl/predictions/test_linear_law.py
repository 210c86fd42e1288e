"""Linear laws against difference equations and unicycles iterated here, in plain numpy."""

from itertools import product

import numpy as np
import pytest

from setcmas_ctrl.predictions.conditions import Conditions, Departure
from setcmas_ctrl.predictions.linear_law import Doubt, LinearLaw, stable_delay

RING = np.roll(np.eye(6), 1, axis=1)
GRAPHS = {
    'directed ring': RING,
    'ring': RING + RING.T,
    'path': np.eye(6, k=1) + np.eye(6, k=-1),
    'complete': 1.0 - np.eye(6),
}
H, TS, SPEED = 0.2, 0.1, 0.5
RATE = 'consensus.convergence_rate_1_s'
TOLERABLE = 'delay.tolerable_delay_of_all_poses_at_most_s'


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


@pytest.mark.parametrize(
    ('K', 'grows'), [(0.45, False), (0.47, False), (0.48, True), (0.6, True), (0.7, True)]
)
def test_all_positions_late_on_a_directed_ring_grow_where_the_equation_does(K, grows):
    law = laplacian_law(RING, K, own_delay=1.0)
    doubt = law.doubt(conditions(RING, delay=1.0))

    assert (growth(RING, K, 1.0, 1.0) > 1.0) == grows
    assert doubt == (Doubt.OSCILLATES if grows else None)


@pytest.mark.parametrize(('nb_robots', 'h'), [(8, 0.04), (30, 0.2)])
def test_large_fleets_with_all_positions_late_are_judged(nb_robots, h):
    complete = 1.0 - np.eye(nb_robots)
    given = conditions(complete, period=h, delay=2.0)

    for K, grows in ((1.4 / 2 / nb_robots, False), (1.6 / 2 / nb_robots, True)):
        assert (growth(complete, K, 2.0, 2.0, h) > 1.0) == grows
        doubt = laplacian_law(complete, K, 2.0).doubt(given)
        assert doubt == (Doubt.OSCILLATES if grows else None)
    assert laplacian_law(complete, 0.01, 0.4).doubt(given) is Doubt.UNJUDGED


def test_an_own_position_that_alone_is_late_does_not_oscillate():
    ring, complete = GRAPHS['ring'], 1.0 - np.eye(4)

    assert laplacian_law(ring, 0.2, 2.0).doubt(conditions(ring)) is None
    assert growth(ring, 0.2, 2.0, 0.0) < 1.0
    law = laplacian_law(complete, 0.2, 2.0)  # all drift away: K d tau = 1.2 > 1
    assert law.doubt(conditions(complete)) is Doubt.DIVERGES


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
    assert law.doubt(conditions(two)) is Doubt.UNLINKED


def test_at_the_limit_of_the_gain_oscillations_persist():
    pair = 1.0 - np.eye(2)

    assert laplacian_law(pair, 5.0).doubt(conditions(pair)) is Doubt.OSCILLATES  # h K lambda = 2
    assert growth(pair, 5.0, 0.0, 0.0) == pytest.approx(1.0)
    assert laplacian_law(pair, 4.9).doubt(conditions(pair)) is None


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


@pytest.mark.parametrize('graph', ['ring', 'directed ring'])
def test_points_bear_the_delay_of_all_poses(graph):
    adjacency, K, h = GRAPHS[graph], 0.3, 0.02
    law = laplacian_law(adjacency, K)
    margin = theorems(law, conditions(adjacency, period=h))[TOLERABLE].value

    assert growth(adjacency, K, *[round(0.97 * margin / h) * h] * 2, h) < 1.0
    assert growth(adjacency, K, *[round(1.03 * margin / h) * h] * 2, h) > 1.0


def test_unicycles_bear_less():
    given = conditions(GRAPHS['complete'], komega=1.5)
    found = theorems(laplacian_law(GRAPHS['complete'], 0.5 / 6), given)

    assert found[TOLERABLE].value == pytest.approx(0.947, abs=1e-3)


def test_no_delay_is_promised_to_unicycles_whose_positions_are_as_fast_as_their_headings():
    given = conditions(GRAPHS['complete'], komega=1.5)

    assert disagreement(2.0, 1.5, 0.6, 300.0)[-1] > 1.0  # less than pi/(2 K) - h/2 = 0.685 s
    assert TOLERABLE not in theorems(laplacian_law(GRAPHS['complete'], 2.0 / 6), given)


def test_no_delay_is_promised_to_points_near_the_limit_of_their_gain():
    complete, h = 1.0 - np.eye(8), 0.02
    law = laplacian_law(complete, 12.0)  # h K lambda = 1.92

    assert growth(complete, 12.0, h, h, h) > 1.0
    assert growth(complete, 12.0, 0.0, 0.0, h) < 1.0
    assert TOLERABLE not in theorems(law, conditions(complete, period=h))


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


def disagreement(K, komega, delay, seconds=150.0):
    """Return the RMS distance of eight unicycles to their centre in m, all poses late, (steps,).

    They follow v_i = -K (p_i - mean) from the default places of the ROS 1 stack.
    """
    x, y = np.array([p for p in product((5.0, 0.0, -5.0), repeat=2) if any(p)]).T
    theta, V, omega = np.zeros((3, 8))
    past, distances = [], []
    for k in range(round(seconds / TS)):
        past.append((x, y, theta))
        if k % round(H / TS) == 0:
            seen_x, seen_y, seen_theta = past[max(0, k - round(delay / TS))]
            vx, vy = -K * (seen_x - seen_x.mean()), -K * (seen_y - seen_y.mean())
            V = np.minimum(np.hypot(vx, vy), SPEED)
            V[V < 0.01] = 0.0
            error = np.angle((vx + 1j * vy) * np.exp(-1j * seen_theta))
            omega = np.where(V > 0.0, komega * error, 0.0)
        theta = theta + TS * omega
        x, y = x + TS * V * np.cos(theta), y + TS * V * np.sin(theta)
        distances.append(np.hypot(x - x.mean(), y - y.mean()))
    return np.sqrt(np.mean(np.square(distances), axis=1))


@pytest.mark.parametrize(('K', 'komega'), [(0.5, 1.5), (0.2, 1.5), (0.5, 3.0), (0.3, 1.0)])
def test_unicycles_drive_away_from_the_margin_on(K, komega):
    margin = stable_delay(max(K, komega), H)

    assert disagreement(K, komega, np.floor(0.8 * margin / TS) * TS)[-200:].max() < 0.05
    assert disagreement(K, komega, np.ceil(margin / TS) * TS)[-200:].max() > 7.0


def test_the_gains_by_default_bear_what_was_measured():
    assert stable_delay(1.5, H) == pytest.approx(0.947, abs=1e-3)
    assert disagreement(0.5, 1.5, 0.8)[-200:].max() < 0.03
    late = disagreement(0.5, 1.5, 1.0, 300.0)
    assert late[-1] > late[1000] > 5.0
