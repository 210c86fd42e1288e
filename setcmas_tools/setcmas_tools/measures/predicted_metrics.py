"""What theory says of runs of the built-in laws, next to what their metrics measure.

A law is the loaded script, with the values of --set. Only figures that a metric measures are
predicted.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache
from math import asin, log
from typing import Any

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.laws.script_loader import ALGORITHMS, load_script
from setcmas_simu.arrays import Floats
from setcmas_simu.robots.model import Motion
from setcmas_simu.robots.models_by_name import motion_of
from setcmas_tools.measures.metric import Measured, words_and_unit
from setcmas_tools.measures.robot_metrics import largest_speed
from setcmas_tools.run.fleet_motion import held_poses
from setcmas_tools.run.run import Run, models_of
from setcmas_tools.run.run_records import FilteredCommands

_AT_LIMIT = 0.999
_DIGITS = 6  # of what a sum that should be 0 has
_NOTHING = 1e-7  # rounding leaves 1e-8 of a double eigenvalue 0
_MEETING_POINT = {
    'consensus': ('final_centre_x_m', 'final_centre_y_m'),
    'alignment': ('final_mean_vx_m_s', 'final_mean_vy_m_s'),
}
"""Metrics by the names of tasks."""

_MOST_ROBOTS = 300
"""Larger fleets are not predicted: their eigenvalues would take seconds."""


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
        return np.diag(self.adjacency.sum(axis=1)) - self.adjacency


@dataclass(frozen=True)
class Figure:
    """A predicted figure.

    Attributes:
        metric: The metric that measures it, such as 'consensus.convergence_rate_1_s'.
        predicted: Its value, in the unit of the metric.
        formula: Where it comes from, such as 'lambda_2 of K L'.
        measured: The measured value; None if the metric does not apply to the run.
    """

    metric: str
    predicted: float
    formula: str
    measured: float | None = None

    def line(self) -> str:
        """Return both values, and where the predicted one comes from."""
        words, unit = words_and_unit(self.metric.rpartition('.')[2])
        measured = '' if self.measured is None else f', measured {_number(self.measured)}'
        value = f'{_number(self.predicted)} {unit}'.rstrip()
        return f'theory: {words} {value} ({self.formula}){measured}'


def _number(value: float) -> str:
    return f'{_rounded(value):.3g}'


def _rounded(value: float) -> float:
    return round(value, _DIGITS) + 0.0


class Comparison(Measured):
    """What theory says of a run.

    Attributes:
        figures: The predicted figures; the last one of a metric is the closest to the run.
        departures: What the theory leaves out and this run has, with a detail or ''.
    """

    def __init__(self, figures: Sequence[Figure], departures: Mapping[Departure, str]) -> None:
        self.figures, self.departures = figures, departures
        left_out = [
            f'{one.value} ({detail})' if detail else one.value
            for one, detail in departures.items()
        ]
        lines = [one.line() for one in figures]
        if lines and left_out:
            lines.append(f'the theory leaves out: {"; ".join(left_out)}')
        values = {
            **{one.metric.replace('.', '_'): _rounded(one.predicted) for one in figures},
            'formulas': list(dict.fromkeys(one.formula for one in figures)),
            'left_out': left_out,
        }
        super().__init__(
            values, lines or ['theory: the law predicts nothing for these conditions']
        )

    def figure(self, metric: str) -> Figure | None:
        """Return the last figure of a metric; None if there is none."""
        return {one.metric: one for one in self.figures}.get(metric)


def compared(run: Run, parts: Mapping[str, Measured]) -> Comparison | None:
    """Return what theory says of the law of a run and its metrics; None if it says nothing.

    Only built-in laws are predicted, because this runs their code: a script of the run counts as
    such a law if it has the same text.
    """
    scripts = [one.contents[0] for one in run.inputs if one.option == 'algo']
    name = _predicted_law(scripts[0]) if len(scripts) == 1 else None
    if name is None or not (conditions := conditions_of(run)):
        return None
    left_out = departures(run)
    figures = []
    # Robots with late messages, or whose graph changes, meet elsewhere.
    is_too_different = bool({Departure.CHANGES, Departure.DELAY} & left_out.keys())
    if not is_too_different and len(conditions.adjacency) <= _MOST_ROBOTS:
        law = load_script(ALGORITHMS.file(name), 1, settings=run.parameters.get('set') or {})
        for one in PREDICTIONS[name](law, conditions):
            metric, _, field = one.metric.partition('.')
            value = parts[metric].get(field) if metric in parts else None
            figures.append(replace(one, measured=None if value is None else float(value)))
    return Comparison(figures, left_out)


@cache
def _predicted_law(script: bytes) -> str | None:
    """Return the name of the built-in law with this text; None if it has no predictions."""
    names = (name for name in PREDICTIONS if ALGORITHMS.file(name).read_bytes() == script)
    return next(names, None)


def conditions_of(run: Run) -> Conditions | None:
    """Return the conditions of a run; None if they are unknown.

    Robots start at their last poses at or before the first command.
    """
    grid, given = run.counted_grid, run.parameters
    rate, count = float(given.get('rate') or 0.0), len(grid.robots)
    starts = held_poses(run.table, 0.0, grid.robots)
    if not rate or not len(grid.t) or not np.isfinite(starts).all():
        return None
    adjacency = 1.0 - np.eye(count)
    if run.record:
        adjacency = run.record.adjacency(float(grid.t[0]), max(grid.robots))
        if len(adjacency) != count:
            return None
    duration = float(grid.t[-1] - grid.t[0])
    return Conditions(starts, adjacency, 1.0 / rate, duration)


def departures(run: Run) -> dict[Departure, str]:
    """Return what a run has and points without limits have not, each with a detail or ''."""
    given, commands, record = run.parameters, run.commands, run.record
    turns = any(motion_of(model) is not Motion.FREE for model in models_of(run).values())
    found: dict[Departure, str | bool] = {Departure.TURNING: turns}
    found[Departure.OWN_TURNING] = any(one.option == 'si_to_uni' for one in run.inputs)
    if commands is not None:
        t, speeds = commands.t, np.hypot(commands.vx, commands.vy)
        if (fast := speeds >= _AT_LIMIT * largest_speed(run)).any():
            found[Departure.SPEED_LIMIT] = f'reached until {t[fast].max():.1f} s'
        drive = np.isin(commands.robot, np.unique(commands.robot[speeds > 0.0]))
        if (stopped := drive & (speeds == 0.0) & (t > t[0])).any():  # a memory may begin at 0
            found[Departure.REST] = f'from {t[stopped].min():.1f} s'
        found[Departure.FILTER] = isinstance(commands, FilteredCommands)
    if record:
        lost = sum(one.lost for one in record.links.values())
        found[Departure.LOSS] = f'{lost:,}' if lost else False
        found[Departure.EVENTS] = record.is_event_triggered
        found[Departure.CHANGES] = len(np.unique(record.changes[:, 0])) > 1
    found[Departure.DELAY] = bool(given.get('delay'))
    found[Departure.NOISE] = bool(given.get('noise'))
    return {one: '' if detail is True else detail for one, detail in found.items() if detail}


def linear_law(
    conditions: Conditions,
    matrix: NDArray[Any],
    formula: str,
    task: str = 'consensus',
    kept: int = 1,
    starts: Floats | None = None,
) -> list[Figure]:
    """Return the rates and the meeting point of a law z' = -M z.

    z are the positions of all robots, or values that they send each other. Called every h s, the
    law is the sampled model z(k + 1) = z(k) - h M z(k).

    Args:
        conditions: Conditions of the run.
        matrix: M in 1/s, shape (N, N), or a multiple with memories of robots 1, 2, ...
        formula: M in the terms of the law, such as 'K L'.
        task: Task whose metrics measure the agreement, 'consensus' or 'alignment'.
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
    swings = abs(factor.imag) > _NOTHING and not of_robots  # errors rise and fall
    if swings or not _NOTHING < abs(factor) < 1.0 - _NOTHING:
        return []
    found = []
    metric = f'{task}.convergence_rate_1_s'
    if kept == 1 and h * np.abs(values).max() < 1.0:
        name = 'lambda_2' if np.allclose(matrix, matrix.T) else 'least Re lambda'
        found.append(Figure(metric, float(values.real.min()), f'{name} of {formula}'))
    rho = f'sampled model, h = {h:g} s: -ln(rho)/h'
    found.append(Figure(metric, -log(abs(factor)) / h, rho))
    if kept == 1 and of_robots:
        found += _meeting_point(matrix, task, conditions.starts if starts is None else starts)
    return found


def _meeting_point(matrix: NDArray[Any], task: str, starts: Floats) -> list[Figure]:
    """Return the place, or the value, on which robots agree: if w' M = 0, w' z is constant."""
    values, vectors = np.linalg.eig(matrix.T)
    w = vectors[:, np.abs(values).argmin()].real
    by = "mean of the starts with weights w, w' M = 0"
    return [
        Figure(f'{task}.{name}', float(w @ places / w.sum()), by)
        for name, places in zip(_MEETING_POINT[task], starts, strict=False)
    ]


def consensus(law: Any, conditions: Conditions) -> list[Figure]:
    """Predict v_i = -K / (1 + d_i) sum_j a_ij (p_i - p_j)."""
    degrees = conditions.adjacency.sum(axis=1)
    matrix = law.K * conditions.laplacian / (1 + degrees)[:, None]
    return linear_law(conditions, matrix, 'K inv(I + D) L')


def laplacian_consensus(law: Any, conditions: Conditions) -> list[Figure]:
    """Predict v_i = -K sum_j a_ij (p_i - p_j); nothing for late own positions."""
    if law.DELAY:
        return []
    return linear_law(conditions, law.K * conditions.laplacian, 'K L')


def second_order_consensus(law: Any, conditions: Conditions) -> list[Figure]:
    """Predict p'' = -K L p - G L p'; a new velocity uses new positions."""
    L, h = conditions.laplacian, conditions.period
    rows = [[0 * L, -np.eye(len(L))], [law.K * L, (law.G + h * law.K) * L]]
    return linear_law(conditions, np.block(rows), '[0 -I; K L, G L]', kept=2)


def distributed_optimisation(law: Any, conditions: Conditions) -> list[Figure]:
    """Predict p' = -alpha Q (p - c) - beta L p - v, v' = alpha beta L p; nothing without v."""
    if not law.MEMORY:
        return []
    count = len(conditions.adjacency)
    q, pull = np.resize(law.Q, count), law.BETA * conditions.laplacian
    first = law.ALPHA * np.diag(q) + pull
    matrix = np.block([[first, np.eye(count)], [-law.ALPHA * pull, 0 * pull]])
    found = linear_law(conditions, matrix, '[alpha Q + beta L, I; -alpha beta L, 0]')
    if _keeps_mean(conditions):
        found += _centre(conditions.starts[:2] @ q / q.sum(), 'sum_i q_i c_i / sum_i q_i')
    return found


def distance_formation(law: Any, conditions: Conditions) -> list[Figure]:
    """Predict that the centre stays in an undirected graph."""
    del law
    is_undirected = np.array_equal(conditions.adjacency, conditions.adjacency.T)
    centre = conditions.starts[:2].mean(axis=1)
    return _centre(centre, 'sum_i v_i = 0') if is_undirected else []


def velocity_alignment(law: Any, conditions: Conditions) -> list[Figure]:
    """Predict w' = -K L w for the velocities w, which robots send."""
    starts = law.starts(len(conditions.adjacency))
    return linear_law(conditions, law.K * conditions.laplacian, 'K L', 'alignment', starts=starts)


def kuramoto(law: Any, conditions: Conditions) -> list[Figure]:
    """Predict phases theta_i' = w_i + K/N sum_j a_ij sin(theta_j - theta_i) that are near."""
    count = len(conditions.adjacency)
    if count == 2 and 0 < abs(law.DW) <= law.K and conditions.adjacency.sum() == 2:
        lag = 'alignment.spread_of_directions_at_end_rad'
        return [Figure(lag, asin(abs(law.DW) / law.K), 'asin(DW/K)')]
    if law.DW:
        return []
    matrix = law.K / count * conditions.laplacian
    return linear_law(conditions, matrix, 'K L / N', 'alignment', starts=np.empty((0, count)))


def dynamic_average(law: Any, conditions: Conditions) -> list[Figure]:
    """Predict x' = -K L x + r' for the estimates x, which robots send."""
    count = len(conditions.adjacency)
    if count < 2 or not _keeps_mean(conditions):
        return []
    drifts = np.resize(law.DRIFTS, (count, 2))
    errors = np.linalg.norm(np.linalg.pinv(law.K * conditions.laplacian) @ drifts)
    formula = "errors of ramps, pinv(K L) (r' - mean(r'))"
    apart = Figure('consensus.disagreement_at_end_m', float(errors / np.sqrt(count)), formula)
    ends = (conditions.starts[:2] + conditions.duration * drifts.T).mean(axis=1)
    return [apart, *_centre(ends, 'the mean of the targets')]


def _keeps_mean(conditions: Conditions) -> bool:
    """Return whether the graph is balanced and connected."""
    sent, received = conditions.adjacency.sum(axis=0), conditions.adjacency.sum(axis=1)
    is_connected = np.linalg.matrix_rank(conditions.laplacian) == len(sent) - 1
    return np.allclose(sent, received) and bool(is_connected)


def _centre(place: Floats, formula: str) -> list[Figure]:
    """Return where the centre of the robots ends, in m."""
    return [
        Figure('consensus.final_centre_x_m', float(place[0]), formula),
        Figure('consensus.final_centre_y_m', float(place[1]), formula),
    ]


PREDICTIONS: dict[str, Callable[[Any, Conditions], list[Figure]]] = {
    predict.__name__: predict
    for predict in (
        consensus, distance_formation, distributed_optimisation, dynamic_average, kuramoto,
        laplacian_consensus, second_order_consensus, velocity_alignment,
    )
}  # fmt: skip
"""By the names of the laws."""
