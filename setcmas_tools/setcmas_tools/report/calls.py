"""Calls of control laws for the page: what they wanted, what became of it, what they knew."""

from __future__ import annotations

from typing import Any

import numpy as np

from setcmas_ctrl.filter.barrier import Verdict
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.replay.instant import Instants, RobotInstant
from setcmas_tools.report.listing import first_line
from setcmas_tools.report.packing import changes, packed
from setcmas_tools.run.fleet_motion import SAME_TIME_S
from setcmas_tools.run.law_output import MOVING

_MOST_CALLS = 6_000
"""Of all robots; of longer runs each second, fifth, ... call is told."""
_MOST_KNOWN = 300_000
"""Numbers of what robots knew; more would make the page too large for a mail."""
_OVERRULED = {
    Verdict.CHANGED: 'The safety filter overruled it.',
    Verdict.BLOCKED: 'The safety filter overruled it: robots block each other.',
    Verdict.NO_SOLUTION: 'The safety filter stopped it: no velocity was safe.',
}
_TOO_MUCH = 'not on this page: the run is too long for it; setcmas view shows it'


def calls_entry(history: RunHistory) -> dict[int, dict[str, Any]]:
    """Return what the page knows of the calls of each robot's law, by its number."""
    commands, failures = history.run.commands, history.run.info.failures or []
    instants = Instants(history)
    each = 1 + len(commands.t) // _MOST_CALLS if commands else 1
    entries = {}
    for robot in history.robots:
        failed = np.array([one.t for one in failures if one.robot == robot])
        t = commands.of(robot).t if commands else failed
        t = t[t >= history.t0 - SAME_TIME_S][::each]
        if len(t):
            entries[robot] = _calls(history, [instants.of(robot, now) for now in t.tolist()])
    return entries


def _calls(history: RunHistory, calls: list[RobotInstant]) -> dict[str, Any]:
    wanted = np.array([one.wanted or (np.nan, np.nan) for one in calls])
    entry: dict[str, Any] = {
        't': packed([one.t for one in calls]),
        'vx': packed(wanted[:, 0]),
        'vy': packed(wanted[:, 1]),
        'words': changes([state_in_words(one) for one in calls]),
    }
    if any(one.allowed for one in calls):
        allowed = np.array([one.allowed or (np.nan, np.nan) for one in calls])
        entry |= {'allowedX': packed(allowed[:, 0]), 'allowedY': packed(allowed[:, 1])}
    return entry | _known(history, calls)


def state_in_words(one: RobotInstant) -> tuple[str, str]:
    """Return what became of what a law wanted: a kind for the colour, and a text."""
    if one.failure:
        place = f' in line {one.failure.line} of {one.failure.script}' if one.failure.line else ''
        return 'failed', f'Its law failed{place}: {first_line(one.failure)}'
    if one.state not in (None, MOVING):
        return 'stopped', f'The experiment had it {one.state}.'
    if one.overruled:
        return 'overruled', _OVERRULED.get(one.verdict or Verdict.KEPT, 'Safety overruled it.')
    return ('saturated', 'That is the largest speed: saturated.') if one.saturated else ('', '')


def _known(history: RunHistory, calls: list[RobotInstant]) -> dict[str, Any]:
    """Return what a robot knew of the others, if that is not simply where they were."""
    if history.run.record is None:
        return {}
    reason = next((one.unknown for one in calls if one.known is None), '')
    if reason:
        return {'unknown': reason}
    known: Floats = np.array([one.known for one in calls])
    if known.size * len(history.robots) > _MOST_KNOWN:
        return {'unknown': _TOO_MUCH}
    return {
        'known': [
            {
                'name': robot_name(sender + 1),
                'number': sender + 1,
                'x': packed(known[:, 0, sender]),
                'y': packed(known[:, 1, sender]),
            }
            for sender in range(known.shape[2])
            if sender + 1 != calls[0].robot and np.isfinite(known[:, 0, sender]).any()
        ]
    }
