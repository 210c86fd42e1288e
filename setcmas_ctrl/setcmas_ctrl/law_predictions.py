"""What theory says of runs of the built-in laws: rates, meeting points and other figures.

A law is the loaded script, with the values of --set.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache
from math import asin, log
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.communication import graph
from setcmas_ctrl.communication.graph import reachable
from setcmas_ctrl.laws.script_loader import ALGORITHMS, load_script
from setcmas_simu.arrays import Floats


class Departure(Enum):
    """What a run has, and points that follow their law without limits have not."""

    TURNING = 'turning before driving'
    OWN_TURNING = 'a si_to_uni of its own'
    SPEED_LIMIT = 'the speed limit'
    REST = 'robots at rest'
    FILTER = 'the safety filter'
    CHANGES = 'changes of the graph'
    LOSS = 'lost messages'
    DELAY = 'delay of messages'
    NOISE = 'noise of messages'
    EVENTS = 'event-triggered communication'


class Theorem(NamedTuple):
    """A predicted figure.

    Attributes:
        metric: The metric that measures it, such as 'consensus.convergence_rate_1_s'.
        value: Its value, in the unit of the metric.
        formula: Where it comes from, such as 'lambda_2 of K L'.
    """

    metric: str
    value: float
    formula: str


@dataclass(frozen=True)
class Conditions:
    """The conditions of a run.

    Attributes:
        starts: Rows x (m), y (m) and theta (rad) of the robots at the first call, shape (3, N).
        adjacency: Weights of the graph then, shape (N, N): row i receives from column j.
        period: Time between two calls of the laws, in s.
        duration: Length of the run, in s.
    """

    starts: Floats
    adjacency: Floats
    period: float
    duration: float = 0.0

    @property
    def laplacian(self) -> Floats:
        """L = diag(sum_j a_ij) - A, shape (N, N)."""
        return graph.laplacian(self.adjacency)


_NOTHING = 1e-7  # rounding leaves 1e-8 of a double eigenvalue 0
_MEETING_POINT = {
    'consensus': ('final_centre_x_m', 'final_centre_y_m'),
    'alignment': ('final_mean_vx_m_s', 'final_mean_vy_m_s'),
}
"""Metrics by the names of tasks."""


def linear_law(
    conditions: Conditions,
    matrix: NDArray[Any],
    formula: str,
    task: str = '',
    kept: int = 1,
    starts: Floats | None = None,
) -> list[Theorem]:
    """Return the rates and the meeting point of a law z' = -M z.

    z are the positions of all robots, or values that they send each other. Called every h s, the
    law is the sampled model z(k + 1) = z(k) - h M z(k).

    Args:
        conditions: Conditions of the run.
        matrix: M in 1/s, shape (N, N), or a multiple with memories of robots 1, 2, ...; a complex
            M acts on x + i y, and also turns.
        formula: M in the terms of the law, such as 'K L'.
        task: Task whose metrics measure the agreement, 'consensus' or 'alignment'; '' if none do.
        kept: Number of modes that the law keeps: of consensus one, the meeting point.
        starts: Values at the start, if they are no positions: a row per coordinate of their mean,
            shape (2, N), or none, shape (0, N).
    """
    h = conditions.period
    values = np.linalg.eigvals(matrix)
    of_robots = len(values) == len(conditions.adjacency)
    values = values[np.argsort(np.abs(values))][kept:]
    # The factor by which the slowest mode changes from call to call.
    factor = complex(max(1.0 - h * values, key=abs, default=0.0))
    if not _NOTHING < abs(factor) < 1.0 - _NOTHING:
        return []
    found = []
    swings = abs(factor.imag) > _NOTHING and not of_robots  # errors rise and fall
    metric = f'{"modes" if swings else task or "modes"}.convergence_rate_1_s'
    is_symmetric = np.allclose(matrix, matrix.T)
    if kept == 1 and h * np.abs(values).max() < 1.0:
        name = 'lambda_2' if is_symmetric else 'least Re lambda'
        found.append(Theorem(metric, float(values.real.min()), f'{name} of {formula}'))
    rho = f'sampled model, h = {h:g} s: -ln(rho)/h'
    found.append(Theorem(metric, -log(abs(factor)) / h, rho))
    if kept == 1 and task and of_robots:
        found += _meeting_point(matrix, task, conditions.starts if starts is None else starts)
    return found


def _meeting_point(matrix: NDArray[Any], task: str, starts: Floats) -> list[Theorem]:
    """Return the place, or the value, on which robots agree: if w' M = 0, w' z is constant."""
    values, vectors = np.linalg.eig(matrix.T)
    w = vectors[:, np.abs(values).argmin()].real
    by = "mean of the starts with weights w, w' M = 0"
    return [
        Theorem(f'{task}.{name}', float(w @ places / w.sum()), by)
        for name, places in zip(_MEETING_POINT[task], starts, strict=False)
    ]


def consensus(law: Any, conditions: Conditions) -> list[Theorem]:
    """Predict v_i = -K / (1 + d_i) sum_j a_ij (p_i - p_j)."""
    degrees = conditions.adjacency.sum(axis=1)
    matrix = law.K * conditions.laplacian / (1 + degrees)[:, None]
    return linear_law(conditions, matrix, 'K inv(I + D) L', 'consensus')


def laplacian_consensus(law: Any, conditions: Conditions) -> list[Theorem]:
    """Predict v_i = -K sum_j a_ij (p_i - p_j); nothing for late own positions."""
    if law.DELAY:
        return []
    return linear_law(conditions, law.K * conditions.laplacian, 'K L', 'consensus')


def containment(law: Any, conditions: Conditions) -> list[Theorem]:
    """Predict v_i = -K sum_j a_ij (p_i - p_j) of followers, with leaders at rest."""
    rows = [leader - 1 for leader in law.LEADERS if leader <= len(conditions.adjacency)]
    matrix = law.K * conditions.laplacian
    matrix[rows] = 0.0
    return linear_law(conditions, matrix, 'K [L_FF L_FL; 0 0]', kept=max(len(rows), 1))


def cyclic_pursuit(law: Any, conditions: Conditions) -> list[Theorem]:
    """Predict v_i = K R(alpha) (p_(i+1) - p_i) of robots that receive the next one."""
    count = len(conditions.adjacency)
    pursued = np.roll(np.eye(count), 1, axis=1)
    moves = np.sum(conditions.adjacency * pursued, axis=1) > 0
    matrix = law.turned(count) * moves[:, None] * (np.eye(count) - pursued)
    if law.ALPHA is not None and abs(law.ALPHA) < np.pi / count:
        return linear_law(conditions, matrix, 'K R(alpha) (I - P)')
    rate = linear_law(conditions, matrix, 'K R(alpha) (I - P)', kept=count)
    if law.ALPHA is not None or not moves.all() or count < 3:
        return rate
    radius = np.abs(np.fft.fft(conditions.starts[0] + 1j * conditions.starts[1])[-1]) / count
    turn, h = 2 * law.K * np.sin(np.pi / count), conditions.period
    radius *= abs(1.0 + 1j * h * turn) ** (conditions.duration / h)  # calls enlarge the circle
    formula = '|DFT_(N-1) of x + i y|/N |1 + i h w|^(T/h), w = 2 K sin(pi/N)'
    return [
        *rate,
        Theorem('circle.radius_at_end_m', float(radius), formula),
        Theorem('circle.turn_rate_rad_s', float(turn), '2 K sin(pi/N)'),
    ]


def second_order_consensus(law: Any, conditions: Conditions) -> list[Theorem]:
    """Predict p'' = -K L p - G L p'; a new velocity uses new positions."""
    L, h = conditions.laplacian, conditions.period
    rows = [[0 * L, -np.eye(len(L))], [law.K * L, (law.G + h * law.K) * L]]
    return linear_law(conditions, np.block(rows), '[0 -I; K L, G L]', 'consensus', kept=2)


def distributed_optimisation(law: Any, conditions: Conditions) -> list[Theorem]:
    """Predict p' = -alpha Q (p - c) - beta L p - v, v' = alpha beta L p."""
    count = len(conditions.adjacency)
    q, pull = np.resize(law.Q, count), law.BETA * conditions.laplacian
    matrix = law.ALPHA * np.diag(q) + pull
    if not law.MEMORY:
        return linear_law(conditions, matrix, 'alpha Q + beta L', kept=0)
    matrix = np.block([[matrix, np.eye(count)], [-law.ALPHA * pull, 0 * pull]])
    centre = conditions.starts[:2] @ q / q.sum()
    theorems = _centre(centre, 'sum_i q_i c_i / sum_i q_i') if _keeps_mean(conditions) else []
    formula = '[alpha Q + beta L, I; -alpha beta L, 0]'
    return linear_law(conditions, matrix, formula, 'consensus') + theorems


def bearing_formation(law: Any, conditions: Conditions) -> list[Theorem]:
    """Predict p' = -K B p with the bearing Laplacian B, for x of all robots, then y."""
    normal = law.normals(len(conditions.adjacency))
    weights = conditions.adjacency * normal[:, None] * normal  # (2, 2, N, N)
    blocks = np.eye(len(conditions.adjacency)) * weights.sum(axis=-1)[..., None] - weights
    B = np.block([list(row) for row in blocks])
    return linear_law(conditions, law.K * B, 'K B', kept=3)


def distance_formation(law: Any, conditions: Conditions) -> list[Theorem]:
    """Predict that the centre stays in an undirected graph."""
    del law
    is_undirected = np.array_equal(conditions.adjacency, conditions.adjacency.T)
    centre = conditions.starts[:2].mean(axis=1)
    return _centre(centre, 'sum_i v_i = 0') if is_undirected else []


def velocity_alignment(law: Any, conditions: Conditions) -> list[Theorem]:
    """Predict w' = -K L w for the velocities w, which robots send."""
    starts = law.starts(len(conditions.adjacency))
    return linear_law(conditions, law.K * conditions.laplacian, 'K L', 'alignment', starts=starts)


def kuramoto(law: Any, conditions: Conditions) -> list[Theorem]:
    """Predict phases theta_i' = w_i + K/N sum_j a_ij sin(theta_j - theta_i) that are near."""
    count = len(conditions.adjacency)
    matrix = law.K / count * conditions.laplacian
    if count == 2 and 0 < abs(law.DW) <= law.K and conditions.adjacency.sum() == 2:
        lag = 'alignment.spread_of_directions_at_end_rad'
        return [Theorem(lag, asin(abs(law.DW) / law.K), 'asin(DW/K)')]
    task = '' if law.DW else 'alignment'
    return linear_law(conditions, matrix, 'K L / N', task, starts=np.empty((0, count)))


def dynamic_average(law: Any, conditions: Conditions) -> list[Theorem]:
    """Predict x' = -K L x + r' for the estimates x, which robots send."""
    count = len(conditions.adjacency)
    matrix = law.K * conditions.laplacian
    rate = linear_law(conditions, matrix, 'K L', starts=np.empty((0, count)))
    if count < 2 or not _keeps_mean(conditions):
        return rate
    drifts = np.resize(law.DRIFTS, (count, 2))
    errors = np.linalg.norm(np.linalg.pinv(matrix) @ drifts) / np.sqrt(count)
    ends = (conditions.starts[:2] + conditions.duration * drifts.T).mean(axis=1)
    formula = "errors of ramps, pinv(K L) (r' - mean(r'))"
    apart = Theorem('consensus.disagreement_at_end_m', float(errors), formula)
    return [*rate, apart, *_centre(ends, 'the mean of the targets')]


def _keeps_mean(conditions: Conditions) -> bool:
    """Return whether the graph is balanced and connected."""
    sent, received = conditions.adjacency.sum(axis=0), conditions.adjacency.sum(axis=1)
    return np.allclose(sent, received) and bool(reachable(conditions.adjacency).all())


def _centre(place: Floats, formula: str) -> list[Theorem]:
    """Return where the centre of the robots ends, in m."""
    return [
        Theorem('consensus.final_centre_x_m', float(place[0]), formula),
        Theorem('consensus.final_centre_y_m', float(place[1]), formula),
    ]


PREDICTIONS: dict[str, Callable[[Any, Conditions], list[Theorem]]] = {
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


def predicted(name: str, settings: Mapping[str, Any], conditions: Conditions) -> list[Theorem]:
    """Return what theory says of a run of a law; nothing of more than 300 robots.

    `settings` are the values of --set by name.
    """
    if len(conditions.adjacency) > _MOST_ROBOTS:
        return []
    law = load_script(ALGORITHMS.file(name), 1, settings=settings)
    return PREDICTIONS[name](law, conditions)
