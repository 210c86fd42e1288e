"""Sentence on robots that are meant to meet: how near they came, where, how fast, and theory."""

from __future__ import annotations

from collections.abc import Mapping
from math import hypot, pi

from setcmas_ctrl.predictions.conditions import Departure
from setcmas_simu.robots.model import SLOW
from setcmas_tools.measures.consensus_metrics import ConsensusMetrics, Starts
from setcmas_tools.measures.metric import Measured
from setcmas_tools.measures.predicted_metrics import Comparison
from setcmas_tools.measures.safety_metrics import Separation

_SHOWN_M = 0.005  # shorter distances read 0.00 m
_RATES_DIFFER = 0.05
_DIRECTIONS = ('+x', '+y', '-x', '-y')


def meeting(parts: Mapping[str, Measured]) -> str:
    """Return the sentence from the metrics of a run by name; '' if its robots need not meet."""
    agreement, separation, theory = map(parts.get, ('consensus', 'separation', 'prediction'))
    if not isinstance(agreement, ConsensusMetrics) or agreement.starts is None:
        return ''
    text = f'The robots {"met" if agreement.have_met else "did not meet"}'
    if isinstance(separation, Separation) and separation.largest_distance_at_end_m is not None:
        text += f': at most {separation.largest_distance_at_end_m:.2f} m apart at the end'
    predicted, limit = {}, ''
    if isinstance(theory, Comparison):
        predicted = {figure.metric: figure.predicted for figure in theory.figures}
        limit = theory.departures.get(Departure.SPEED_LIMIT, '')
        if agreement.have_met and 'consensus.final_centre_x_m' in predicted:
            x, y = (predicted[f'consensus.final_centre_{axis}_m'] for axis in 'xy')
            away = hypot(agreement.final_centre_x_m - x, agreement.final_centre_y_m - y)
            text += f', {away:.2f} m from {_place(agreement.starts, x, y)}'
            reasons = _reasons(agreement.starts, x, y, theory) if away > _SHOWN_M else []
            text += f' ({"; ".join(reasons)})' if reasons else ''
    if agreement.convergence_rate_1_s is None:
        return f'{text}.'
    expected = predicted.get('consensus.convergence_rate_1_s')
    theory_too = '' if expected is None else f', theory {expected:.3g}'
    if expected and abs(agreement.convergence_rate_1_s / expected - 1.0) > _RATES_DIFFER:
        theory_too += f' (the speed limit was {limit})' if limit else ''
    return f'{text}. Rate {agreement.convergence_rate_1_s:.3g} 1/s{theory_too}.'


def _place(starts: Starts, x: float, y: float) -> str:
    """Return where theory has the robots meet, in words."""
    if _is_mean(starts, x, y):
        return 'the mean of their starts'
    return f'({x:.2f}, {y:.2f}), where theory has them meet'


def _is_mean(starts: Starts, x: float, y: float) -> bool:
    return hypot(starts.x - x, starts.y - y) < _SHOWN_M


def _reasons(starts: Starts, x: float, y: float, theory: Comparison) -> list[str]:
    """Return why the centre of the robots is not where theory has them meet."""
    reasons = []
    if Departure.TURNING in theory.departures:
        faced = 'they' if starts.heading is None else 'all faced one way and'
        if starts.heading is not None and abs(starts.heading % (pi / 2)) < 1e-3:
            faced = f'all faced {_DIRECTIONS[round(starts.heading / (pi / 2)) % 4]} and'
        reasons.append(f'{faced} drove while turning, which omnidirectional robots need not')
    is_balanced = _is_mean(starts, x, y) and starts.speed < SLOW
    if Departure.SPEED_LIMIT in theory.departures and not is_balanced:
        reasons.append('the speed limit slowed some more than others')
    return reasons
