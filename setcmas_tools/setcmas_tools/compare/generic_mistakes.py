"""Generic mistakes: what becomes of the right answers, whatever the law or condition is."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_tools.offline.altered_solutions import Calls

TURNED: tuple[tuple[str, Callable[[Floats, Floats], tuple[Floats, Floats]]], ...] = (
    (
        'Your velocities are the opposite of the right ones: check the sign.',
        lambda vx, vy: (-vx, -vy),
    ),
    (
        'Your velocities are the right ones with both components swapped: return vx, vy, in this '
        'order.',
        lambda vx, vy: (vy, vx),
    ),
    ('Your velocities are the right ones turned by +90 degrees.', lambda vx, vy: (-vy, vx)),
    ('Your velocities are the right ones turned by -90 degrees.', lambda vx, vy: (vy, -vx)),
    ('Only the sign of vx is wrong.', lambda vx, vy: (-vx, vy)),
    ('Only the sign of vy is wrong.', lambda vx, vy: (vx, -vy)),
    ('Your velocities are all zero.', lambda vx, vy: (0 * vx, 0 * vy)),
    ('vx is right, but vy is always zero.', lambda vx, vy: (vx, 0 * vy)),
    ('vy is right, but vx is always zero.', lambda vx, vy: (0 * vx, vy)),
    ('vx is right, but vy is the same number as vx.', lambda vx, _: (vx, vx)),
    ('vy is right, but vx is the same number as vy.', lambda _, vy: (vy, vy)),
)
"""Velocities made of both components of the right ones."""

POLAR = (
    'You seem to return speed and turn rate. Return vx and vy in the world frame instead: setcmas '
    'itself converts them to speed and turn rate.'
)
SAME_TIME = (
    'Your law does what the right one does at t = 0, at every time: it does not use t, the last '
    'argument of control.'
)


ANSWERS: tuple[tuple[str, Callable[[Floats], Floats]], ...] = (
    (
        'Your condition always holds, so the robots send every time. Compare the direction of the '
        'comparison with the formula.',
        np.ones_like,
    ),
    ('Your condition never holds: the robots only send their first state.', np.zeros_like),
    ('Your condition is the opposite of the right one: check the comparison.', lambda x: 1 - x),
)
"""Answers of a condition, made of the right ones; the first that fits counts."""


FACTORS: dict[str, Callable[[int], float]] = {
    'N': lambda n: n,
    '1/N': lambda n: 1 / n,
    'N-1': lambda n: n - 1,
    '1/(N-1)': lambda n: 1 / (n - 1),
    'N/(N-1)': lambda n: n / (n - 1),
    '(N-1)/N': lambda n: (n - 1) / n,
    '180/pi': lambda _: 180 / math.pi,
    'pi/180': lambda _: math.pi / 180,
}
"""Factors by name, for fleets of N robots."""


def polar(calls: Calls) -> Iterator[Floats]:
    """Yield speeds with what students return as turn rates: heading error, or direction."""
    vx, vy = np.moveaxis(calls.solution, -1, 0)
    speed, direction = np.hypot(vx, vy), np.arctan2(vy, vx)
    error = np.angle(np.exp(1j * (direction - calls.heading)))
    komega = calls.scenario.law.komega
    for length in (speed, np.minimum(speed, calls.limit)):
        for turn in (error, direction, direction - calls.heading):
            yield np.stack([length, komega * turn], -1)
            yield np.stack([length, np.degrees(turn)], -1)
            yield np.stack([length, turn], -1)


BODY = (
    'Your velocities are turned by the heading of the robot. Return vx and vy in the world frame: '
    'they do not depend on the heading.'
)


def in_body_frame(calls: Calls, sign: int) -> Floats:
    """Return the right velocities turned by the robots' headings, with a sign."""
    turned = (calls.solution @ np.array([1, 1j])) * np.exp(1j * sign * calls.heading)
    return np.stack([turned.real, turned.imag], -1)
