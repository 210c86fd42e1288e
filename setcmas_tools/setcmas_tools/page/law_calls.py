"""Calls of control laws on a page: wanted velocities, and their outcomes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.filter.filter_options import Verdict
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function, ScriptFailure
from setcmas_tools.measures.robot_metrics import SATURATION_TOLERANCE, largest_speed
from setcmas_tools.page.page_data import changes, packed
from setcmas_tools.run.communication_record import SentMessage
from setcmas_tools.run.fleet_motion import LONGEST_GAP_S, SAME_TIME_S
from setcmas_tools.run.law_output import MOVING
from setcmas_tools.run.run import Run

_MOST_CALLS = 6_000
"""Of all robots; of longer runs the page has each second, fifth, ... call."""
_MOST_MESSAGES = 20_000
_OVERRULED = {
    Verdict.CHANGED: 'The safety filter overruled it.',
    Verdict.NO_SOLUTION: 'The safety filter stopped it: no velocity was safe.',
}

Outcome = tuple[str, str]
"""Outcome of a wanted velocity: a kind, for its colour, and a sentence."""


def begin_of(run: Run) -> float:
    """Return when a page begins, in s: at the first command, or the first pose after it."""
    first, last = float(run.table.t[0]), float(run.table.t[-1])
    return max(first, 0.0) if last > 0.0 else first


def calls_entry(run: Run) -> dict[int, dict[str, Any]]:
    """Return the calls of each robot's law, by its number."""
    begin = begin_of(run) - SAME_TIME_S
    fastest, sent = _fastest(run), _sent_values(run)
    each = 1 + len(run.commands.t) // _MOST_CALLS if run.commands else 1
    entries = {}
    for robot in run.robots:
        if run.commands:
            own = run.commands.of(robot)
            rows = np.flatnonzero(own.t >= begin)[::each]
            t, wanted = own.t[rows], np.column_stack([own.vx, own.vy])[rows]
            filtered = own.allowed
        else:
            t = np.array([one.t for one in run.info.failures or [] if one.robot == robot])
            t = t[t >= begin]
            rows, wanted, filtered = np.arange(len(t)), np.full((len(t), 2), np.nan), None
        if not len(t):
            continue
        verdicts = filtered.verdict[rows] if filtered else np.full(len(t), Verdict.KEPT)
        outcomes = _outcomes(run, robot, t, verdicts, np.hypot(*wanted.T) >= fastest)
        entry = {
            't': packed(t),
            'vx': packed(wanted[:, 0]),
            'vy': packed(wanted[:, 1]),
            'words': changes(outcomes),
        }
        if filtered:
            entry['allowedX'] = packed(filtered.vx[rows])
            entry['allowedY'] = packed(filtered.vy[rows])
        entries[robot] = entry | sent.get(robot, {})
    return entries


def _sent_values(run: Run) -> dict[int, dict[str, Any]]:
    """Return the values that laws sent, as text, by the robots that sent any."""
    if len(run.messages) > _MOST_MESSAGES:
        return {}
    sent: dict[int, list[SentMessage]] = {}
    for message in run.messages:
        sent.setdefault(message.robot, []).append(message)
    return {robot: _texts(messages) for robot, messages in sent.items()}


def _texts(messages: Sequence[SentMessage]) -> dict[str, Any]:
    texts = changes([_in_words(message.value) for message in messages])
    return {'messages': {'t': packed([message.t for message in messages]), 'texts': texts}}


def _in_words(value: Any) -> str:
    """Return a value as short text, such as 'x = 1.5, goal = [2, 3]'."""
    if isinstance(value, Mapping):
        return ', '.join(f'{name} = {_in_words(one)}' for name, one in value.items())
    if not np.ndim(value):
        return f'{value:.4g}'
    return f'[{", ".join(_in_words(one) for one in np.asarray(value))}]'


def _fastest(run: Run) -> float:
    """Return the speed in m/s from which a law is saturated; inf if it is unknown."""
    try:
        return largest_speed(run) * (1 - SATURATION_TOLERANCE)
    except SetcmasError:
        return math.inf


def _outcomes(
    run: Run, robot: int, t: Floats, verdicts: NDArray[Any], saturated: NDArray[Any]
) -> list[Outcome]:
    found = []
    rows = zip(t.tolist(), states_at(run, robot, t), verdicts, saturated, strict=True)
    for now, (state, held), verdict, is_saturated in rows:
        failure = failure_at(run, robot, now)
        outcome = _outcome(failure, state, held, Verdict(int(verdict)))
        if not outcome[0] and is_saturated:
            outcome = 'saturated', 'The velocity is saturated at the speed limit.'
        found.append(outcome)
    return found


def states_at(run: Run, robot: int, t: Floats) -> list[tuple[str, bool]]:
    """Return a robot's state at times in s, and whether safety overruled its law.

    It moves where none is recorded, as in simulations.
    """
    record = run.tables.safety
    if record is None:
        return [(MOVING, False)] * len(t)
    rows = np.flatnonzero(record.robot == robot)
    newest = np.searchsorted(record.t[rows], t + SAME_TIME_S, side='right') - 1
    return [
        (record.state[rows[k]], bool(record.overruled[rows[k]]))
        if k >= 0 and now - record.t[rows[k]] <= LONGEST_GAP_S
        else (MOVING, False)
        for k, now in zip(newest.tolist(), t.tolist(), strict=True)
    ]


def _outcome(failure: ScriptFailure | None, state: str, held: bool, verdict: Verdict) -> Outcome:
    if failure:
        place = f' in line {failure.line} of {failure.script}' if failure.line else ''
        return 'failed', f'Its law failed{place}: {failure.first_line}'
    if state != MOVING:
        return 'stopped', f'The robot was {state} in the experiment.'
    if held or verdict is not Verdict.KEPT:
        return 'overruled', _OVERRULED.get(verdict, 'A safety function overruled it.')
    return '', ''


def failure_at(run: Run, robot: int, t: float) -> ScriptFailure | None:
    """Return the failure of a robot's law at a time in s; None if it worked."""
    for one in reversed(run.info.failures or []):
        until = math.inf if one.until is None else one.until
        own = one.robot == robot and one.function is Function.CONTROL
        if own and one.t - SAME_TIME_S <= t < until - SAME_TIME_S:
            return one
    return None
