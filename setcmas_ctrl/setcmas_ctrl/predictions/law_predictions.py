"""Predictions of the built-in laws; `law` is the loaded script, with the values of --set."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from math import asin
from typing import Any

import numpy as np

from setcmas_ctrl.communication.graph import reachable
from setcmas_ctrl.laws.script_loader import ALGORITHMS, load_script
from setcmas_ctrl.predictions.prediction import Conditions, LinearLaw, Prediction, Theorem
from setcmas_simu.arrays import Floats


def consensus(law: Any, conditions: Conditions) -> Prediction:
    """Predict v_i = -K / (1 + d_i) sum_j a_ij (p_i - p_j)."""
    degrees = conditions.adjacency.sum(axis=1)
    matrix = law.K * conditions.laplacian / (1 + degrees)[:, None]
    return Prediction(LinearLaw(matrix, 'K inv(I + D) L', 'consensus'))


def laplacian_consensus(law: Any, conditions: Conditions) -> Prediction:
    """Predict v_i = -K sum_j a_ij (p_i - p_j); nothing for late own positions."""
    linear = LinearLaw(law.K * conditions.laplacian, 'K L', 'consensus')
    return Prediction(None if law.DELAY else linear)


def containment(law: Any, conditions: Conditions) -> Prediction:
    """Predict v_i = -K sum_j a_ij (p_i - p_j) of followers, with leaders at rest."""
    rows = [leader - 1 for leader in law.LEADERS if leader <= len(conditions.adjacency)]
    matrix = law.K * conditions.laplacian
    matrix[rows] = 0.0
    return Prediction(LinearLaw(matrix, 'K [L_FF L_FL; 0 0]', kept=max(len(rows), 1)))


def cyclic_pursuit(law: Any, conditions: Conditions) -> Prediction:
    """Predict v_i = K R(alpha) (p_(i+1) - p_i) of robots that receive the next one."""
    count = len(conditions.adjacency)
    pursued = np.roll(np.eye(count), 1, axis=1)
    moves = np.sum(conditions.adjacency * pursued, axis=1) > 0
    matrix = law.turned(count) * moves[:, None] * (np.eye(count) - pursued)
    if law.ALPHA is not None and abs(law.ALPHA) < np.pi / count:
        return Prediction(LinearLaw(matrix, 'K R(alpha) (I - P)'))
    linear = LinearLaw(matrix, 'K R(alpha) (I - P)', kept=count)
    if law.ALPHA is not None or not moves.all() or count < 3:
        return Prediction(linear)
    radius = np.abs(np.fft.fft(conditions.starts[0] + 1j * conditions.starts[1])[-1]) / count
    turn, h = 2 * law.K * np.sin(np.pi / count), conditions.period
    radius *= abs(1.0 + 1j * h * turn) ** (conditions.duration / h)  # calls enlarge the circle
    formula = '|DFT_(N-1) of x + i y|/N |1 + i h w|^(T/h), w = 2 K sin(pi/N)'
    return Prediction(
        linear,
        (
            Theorem('circle.radius_at_end_m', float(radius), formula),
            Theorem('circle.turn_rate_rad_s', float(turn), '2 K sin(pi/N)'),
        ),
    )


def second_order_consensus(law: Any, conditions: Conditions) -> Prediction:
    """Predict p'' = -K L p - G L p'; a new velocity uses new positions."""
    L, h = conditions.laplacian, conditions.period
    rows = [[0 * L, -np.eye(len(L))], [law.K * L, (law.G + h * law.K) * L]]
    return Prediction(LinearLaw(np.block(rows), '[0 -I; K L, G L]', 'consensus', kept=2))


def distributed_optimisation(law: Any, conditions: Conditions) -> Prediction:
    """Predict p' = -alpha Q (p - c) - beta L p - v, v' = alpha beta L p."""
    count = len(conditions.adjacency)
    q, pull = np.resize(law.Q, count), law.BETA * conditions.laplacian
    matrix = law.ALPHA * np.diag(q) + pull
    if not law.MEMORY:
        return Prediction(LinearLaw(matrix, 'alpha Q + beta L', kept=0))
    matrix = np.block([[matrix, np.eye(count)], [-law.ALPHA * pull, 0 * pull]])
    centre = conditions.starts[:2] @ q / q.sum()
    theorems = _centre(centre, 'sum_i q_i c_i / sum_i q_i') if _keeps_mean(conditions) else ()
    formula = '[alpha Q + beta L, I; -alpha beta L, 0]'
    return Prediction(LinearLaw(matrix, formula, 'consensus'), theorems)


def bearing_formation(law: Any, conditions: Conditions) -> Prediction:
    """Predict p' = -K B p with the bearing Laplacian B, for x of all robots, then y."""
    normal = law.normals(len(conditions.adjacency))
    weights = conditions.adjacency * normal[:, None] * normal  # (2, 2, N, N)
    blocks = np.eye(len(conditions.adjacency)) * weights.sum(axis=-1)[..., None] - weights
    B = np.block([list(row) for row in blocks])
    return Prediction(LinearLaw(law.K * B, 'K B', kept=3))


def distance_formation(law: Any, conditions: Conditions) -> Prediction:
    """Predict that the centre stays in an undirected graph."""
    del law
    is_undirected = np.array_equal(conditions.adjacency, conditions.adjacency.T)
    centre = conditions.starts[:2].mean(axis=1)
    return Prediction(theorems=_centre(centre, 'sum_i v_i = 0') if is_undirected else ())


def velocity_alignment(law: Any, conditions: Conditions) -> Prediction:
    """Predict w' = -K L w for the velocities w, which robots send."""
    starts = law.starts(len(conditions.adjacency))
    return Prediction(LinearLaw(law.K * conditions.laplacian, 'K L', 'alignment', starts=starts))


def kuramoto(law: Any, conditions: Conditions) -> Prediction:
    """Predict phases theta_i' = w_i + K/N sum_j a_ij sin(theta_j - theta_i) that are near."""
    count = len(conditions.adjacency)
    matrix = law.K / count * conditions.laplacian
    if count == 2 and 0 < abs(law.DW) <= law.K and conditions.adjacency.sum() == 2:
        lag = 'alignment.spread_of_directions_at_end_rad'
        return Prediction(theorems=(Theorem(lag, asin(abs(law.DW) / law.K), 'asin(DW/K)'),))
    task = '' if law.DW else 'alignment'
    return Prediction(LinearLaw(matrix, 'K L / N', task, starts=np.empty((0, count))))


def dynamic_average(law: Any, conditions: Conditions) -> Prediction:
    """Predict x' = -K L x + r' for the estimates x, which robots send."""
    count = len(conditions.adjacency)
    linear = LinearLaw(law.K * conditions.laplacian, 'K L', starts=np.empty((0, count)))
    if count < 2 or not _keeps_mean(conditions):
        return Prediction(linear)
    drifts = np.resize(law.DRIFTS, (count, 2))
    errors = np.linalg.norm(np.linalg.pinv(linear.matrix) @ drifts) / np.sqrt(count)
    ends = (conditions.starts[:2] + conditions.duration * drifts.T).mean(axis=1)
    formula = "errors of ramps, pinv(K L) (r' - mean(r'))"
    apart = Theorem('consensus.disagreement_at_end_m', float(errors), formula)
    return Prediction(linear, (apart, *_centre(ends, 'the mean of the targets')))


def _keeps_mean(conditions: Conditions) -> bool:
    """Return whether the graph is balanced and connected."""
    sent, received = conditions.adjacency.sum(axis=0), conditions.adjacency.sum(axis=1)
    return np.allclose(sent, received) and bool(reachable(conditions.adjacency).all())


def _centre(place: Floats, formula: str) -> tuple[Theorem, ...]:
    """Return where the centre of the robots ends, in m."""
    return (
        Theorem('consensus.final_centre_x_m', float(place[0]), formula),
        Theorem('consensus.final_centre_y_m', float(place[1]), formula),
    )


PREDICTIONS: dict[str, Callable[[Any, Conditions], Prediction]] = {
    predict.__name__: predict
    for predict in (
        bearing_formation, consensus, containment, cyclic_pursuit, distance_formation,
        distributed_optimisation, dynamic_average, kuramoto, laplacian_consensus,
        second_order_consensus, velocity_alignment,
    )
}  # fmt: skip
"""By the names of the laws."""

_MOST_ROBOTS = 300
"""Larger fleets are not predicted: their eigenvalues would take seconds."""


@cache
def predicted_law(script: bytes) -> str | None:
    """Return the name of the built-in law with this text; None if it has no predictions."""
    names = (name for name in PREDICTIONS if ALGORITHMS.file(name).read_bytes() == script)
    return next(names, None)


def predicted(name: str, settings: Mapping[str, Any], conditions: Conditions) -> Prediction:
    """Return what theory says of a run of a law; nothing of more than 300 robots.

    `settings` are the values of --set by name.
    """
    if len(conditions.adjacency) > _MOST_ROBOTS:
        return Prediction()
    law = load_script(ALGORITHMS.file(name), 1, settings=settings)
    return PREDICTIONS[name](law, conditions)
