"""Generic mistakes of laws and si_to_uni, and which of them reproduce a submission."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_tools.grade.altered_solutions import (
    CLOSE,
    FROZEN,
    SATURATED,
    Calls,
    saturated,
)

_LEFT = 0.1
"""Share of the calls unlike the solution's that an explanation may leave unexplained."""
_FEWEST = 10  # calls to estimate a factor from
EQUAL = 0.02  # relative difference of factors
_SMALLEST = 1e-4  # factor of a turn rate

YOURS = 'Your velocities'
"""First words of hints about velocities; also those of some of the robots."""

TURNED: tuple[tuple[str, list[list[int]]], ...] = (
    ('the opposite of the right ones: check the sign.', [[-1, 0], [0, -1]]),
    (
        'the right ones with vx and vy swapped: return vx, vy, in this order; arctan2 takes y, x.',
        [[0, 1], [1, 0]],
    ),
    ('the right ones turned by +90 degrees: (-vy, vx) instead of (vx, vy).', [[0, -1], [1, 0]]),
    ('the right ones turned by -90 degrees: (vy, -vx) instead of (vx, vy).', [[0, 1], [-1, 0]]),
    ('the opposite of the right ones, with vx and vy swapped.', [[0, -1], [-1, 0]]),
    ('right, but with the wrong sign in vx.', [[-1, 0], [0, 1]]),
    ('right, but with the wrong sign in vy.', [[1, 0], [0, -1]]),
    ('all zero.', [[0, 0], [0, 0]]),
    ('right in vx, but vy is always zero.', [[1, 0], [0, 0]]),
    ('right in vy, but vx is always zero.', [[0, 0], [0, 1]]),
    ('right in vx, but vy is the same number as vx.', [[1, 0], [1, 0]]),
    ('right in vy, but vx is the same number as vy.', [[0, 1], [0, 1]]),
)
"""What velocities are, and the matrix that makes them of the right ones."""

POLAR = (
    f'{YOURS} are speed and turn rate. Return vx and vy in the world frame: setcmas itself '
    'converts them to speed and turn rate.'
)
SAME_TIME = (
    'Your law always returns the velocity that is right at t = 0. Does it use t, the last '
    'argument of control?'
)
COMMANDS: tuple[tuple[str, list[list[int]]], ...] = (
    ('Your turn rate has the wrong sign; V is right.', [[1, 0], [0, -1]]),
    ('Your V has the wrong sign; the turn rate is right.', [[-1, 0], [0, 1]]),
    ('Your V and your turn rate both have the wrong sign.', [[-1, 0], [0, -1]]),
    ('You return the turn rate first: return V, omega, in this order.', [[0, 1], [1, 0]]),
    ('Your robots never turn: your turn rate is always zero.', [[1, 0], [0, 0]]),
    ('Your robots turn, but your V is always zero.', [[0, 0], [0, 1]]),
    ('Your robots do not move: V and the turn rate are always zero.', [[0, 0], [0, 0]]),
)
"""What V and omega are, and the matrix that makes them of the right ones."""


FACTORS: dict[str, Callable[[int], float]] = {
    'N': lambda n: n,
    'N-1': lambda n: n - 1,
    'N/(N-1)': lambda n: n / (n - 1),
    'N squared': lambda n: n * n,
    '180/pi': lambda _: 180 / math.pi,
}
"""Factors by name, above 1, for fleets of N robots; they multiply or divide."""


def polar(calls: Calls) -> Iterator[Floats]:
    """Yield speeds with what students return as turn rates: heading error, or direction."""
    vx, vy = np.moveaxis(calls.solution, -1, 0)
    speed, direction = np.hypot(vx, vy), np.arctan2(vy, vx)
    error = np.angle(np.exp(1j * (direction - calls.heading)))
    komega = calls.scenario.law.komega
    for length in (speed, np.minimum(speed, calls.limit)):
        for turn in (error, direction, direction - calls.heading):
            for factor in (komega, np.degrees(1.0), 1.0):
                yield np.stack([length, factor * turn], -1)


BODY = (
    f'{YOURS} are turned by the heading of the robot. Return vx and vy in the world frame: they '
    'do not depend on the heading.'
)


def in_body_frame(calls: Calls, sign: int) -> Floats:
    """Return the right velocities turned by the robots' headings, with a sign."""
    turned = (calls.solution @ np.array([1, 1j])) * np.exp(1j * sign * calls.heading)
    return np.stack([turned.real, turned.imag], -1)


IN_DEGREES = (
    f'{YOURS} have the right lengths, but not the right directions: sin and cos of an angle in '
    'degrees. They take radians.'
)


def in_degrees(calls: Calls) -> Floats:
    """Return velocities with the direction of the right ones, in degrees, taken for radians."""
    vx, vy = np.moveaxis(calls.solution, -1, 0)
    wrong = np.hypot(vx, vy) * np.exp(1j * np.degrees(np.arctan2(vy, vx)))
    return np.stack([wrong.real, wrong.imag], -1)


class Explanation(NamedTuple):
    """A possible hint, and the number of calls of all scenarios that do not agree with it."""

    hint: str
    differing: int


def tried(
    hint: str, calls: Sequence[Calls], answers: Sequence[Floats | None], is_multiple: bool = False
) -> Iterator[Explanation]:
    """Yield an explanation if its answers are those of the submission in all scenarios.

    Multiples of the solution are not compared where the solution is in its dead band.
    """
    before = after = 0
    for one, theirs in zip(calls, answers, strict=True):
        if theirs is None:
            return
        counted = one.is_known if is_multiple else np.ones(one.own.shape[:2], dtype=bool)
        differing = int((one.differs(theirs) & counted).sum())
        if differing > one.may_differ * max(1, counted.sum()):
            return
        after += differing
        before += int((one.differs(one.solution) & counted).sum())
    if before >= _FEWEST and after <= _LEFT * before:
        yield Explanation(hint, after)


def generic_laws(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield explanations by velocities that are turned, swapped, zero or without t."""
    yield from tried(SAME_TIME, calls, [one.answers.get(FROZEN) for one in calls])
    for what, matrix in TURNED:
        yield from tried(f'{YOURS} are {what}', calls, _turned(calls, matrix), is_multiple=True)
    for sign in (1, -1):
        answers = [in_body_frame(one, sign) for one in calls]
        yield from tried(BODY, calls, answers, is_multiple=True)
    yield from tried(IN_DEGREES, calls, [in_degrees(one) for one in calls], is_multiple=True)
    for returned in zip(*(polar(one) for one in calls), strict=True):
        yield from tried(POLAR, calls, returned, is_multiple=True)


def _turned(calls: Sequence[Calls], matrix: list[list[int]]) -> list[Floats]:
    return [one.solution @ np.transpose(matrix) for one in calls]


def generic_conversions(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield explanations of a si_to_uni whose V and omega are swapped, zero, or of wrong sign."""
    for hint, matrix in COMMANDS:
        yield from tried(hint, calls, _turned(calls, matrix), is_multiple=True)


def other_turn_rate(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield the explanation of a si_to_uni whose turn rate is wrong by a factor."""
    own, right = (
        np.concatenate([each.reshape(-1, 2)[:, 1] for each in found])
        for found in ([one.own for one in calls], [one.solution for one in calls])
    )
    turns = np.abs(right) > CLOSE
    if turns.sum() < _FEWEST:
        return
    factor = float(np.median(own[turns] / right[turns]))
    size = abs(factor)
    if size < _SMALLEST:
        return  # as good as zero
    sign = ' and has the wrong sign' if factor < 0 else ''
    hint = (
        f'V is right, but your turn rate is {times_too(size)}{sign}. '
        'Does it depend on L as in the formula?'
    )
    yield from tried(hint, calls, [one.solution * (1.0, factor) for one in calls])


def times_too(size: float) -> str:
    """Return by which factor something is too large or too small, such as '3 times too large'."""
    return f'{size:.3g} times too large' if size > 1 else f'{1 / size:.3g} times too small'


def scaled(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield explanations by a factor that has a name, otherwise by another constant."""
    found = [*_multiple(calls)]
    yield from found or _constants(calls)


def _multiple(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield the explanation by a factor that has a name."""
    factors = [_factor(one, one.solution) for one in calls]
    sizes = [one.scenario.nb_robots for one in calls]
    known = [place for place, factor in enumerate(factors) if math.isfinite(factor)]
    found = [factors[place] for place in known]
    for name, of_size in FACTORS.items():
        for power in (1, -1):
            wanted = [of_size(size) ** power for size in sizes if size > 1]
            if len(wanted) < len(sizes) or not known:
                return
            if _are_equal(found, [wanted[place] for place in known]):
                names = [name, ', where N is the number of robots'] if 'N' in name else [name, '']
                if 'N' in name and len({sizes[place] for place in known}) == 1:
                    # It may be another number.
                    names = [f'{of_size(sizes[known[0]]):.3g}', f' ({name} for N robots)']
                yield from _by_factors(calls, wanted, *names)


def plain_multiple(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield the explanation by any factor, the same in all scenarios."""
    found = [_factor(one, one.solution) for one in calls]
    known = [factor for factor in found if math.isfinite(factor) and factor]
    if known and _are_equal(known, known[:1] * len(known)):
        size = abs(known[0])
        yield from _by_factors(calls, known[:1] * len(calls), f'{max(size, 1 / size):.3g}')


def _by_factors(
    calls: Sequence[Calls], factors: Sequence[float], name: str, explained: str = ''
) -> Iterator[Explanation]:
    answers = [factor * one.solution for factor, one in zip(factors, calls, strict=True)]
    size = 'large' if abs(factors[0]) > 1 else 'small'
    ways = (
        'the right directions, but are' if factors[0] > 0 else 'the opposite directions, and are'
    )
    hint = f'{YOURS} have {ways} {name} times too {size}{explained}.'
    yield from tried(hint, calls, answers, is_multiple=True)


def shares(
    calls: Sequence[Calls], starts: Sequence[Floats], steps: Sequence[Floats]
) -> list[float]:
    """Return the x for which all submissions are start + x * step; nothing if it varies."""
    each = zip(calls, steps, starts, strict=True)
    known = [share for share in (_factor(*one) for one in each) if math.isfinite(share)]
    return known[:1] if known and _are_equal(known, known[:1] * len(known)) else []


def _factor(calls: Calls, direction: Floats, start: Floats | None = None) -> float:
    """Return the x for which the submission is start + x * direction; NaN if unknown.

    Where the submission is saturated, only its direction is known.
    """
    moves = np.hypot(direction[..., 0], direction[..., 1]) > CLOSE / 10
    free = calls.is_free & moves
    if free.sum() >= _FEWEST:
        own = calls.own[free] if start is None else calls.own[free] - start[free]
        along = direction[free]
        return float(np.median((own * along).sum(-1) / (along * along).sum(-1)))
    if start is None:
        return math.nan
    across = _cross(calls.own, direction)
    known = calls.is_known & (np.abs(across) > CLOSE * calls.limit)
    if known.sum() < _FEWEST:
        return math.nan
    return float(np.median(-_cross(calls.own, start)[known] / across[known]))


def _cross(first: Floats, second: Floats) -> Floats:
    """Return the cross products of vectors, shape (..., 2)."""
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]


def _are_equal(factors: Sequence[float], others: Sequence[float]) -> bool:
    return bool(np.allclose(factors, others, rtol=EQUAL, atol=1e-6))


def _constants(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield explanations by another value of a constant, in which the law must be affine."""
    for name in set.intersection(*(set(one.values) for one in calls)):
        steps = [one.answers[name] - one.solution for one in calls]
        found = [1 + share for share in shares(calls, [one.solution for one in calls], steps)]
        plain = [one for one in (0.0, -1.0) if not (found and _are_equal([one], found))]
        ratios = plain + found
        value = calls[0].values[name]
        for ratio in ratios:
            answers = [
                one.solution + (ratio - 1) * step for one, step in zip(calls, steps, strict=True)
            ]
            hint = _constant_hint(name, value * ratio, value)
            yield from tried(hint, calls, answers, is_multiple=True)


def _constant_hint(name: str, found: float, right: float) -> str:
    if abs(found) < EQUAL * abs(right):
        return f'Your robots move as if {name} were 0: the term with {name} has no effect.'
    if abs(found + right) < EQUAL * abs(right):
        return f'The term with {name} has the wrong sign; the rest is right.'
    return f'Your robots move as if {name} were {found:.3g}, not {right:g}; the rest is right.'


def fixed_length(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield the explanation of velocities in the right directions that have one length."""
    speeds = np.concatenate([one.speeds[one.is_known] for one in calls])
    if not speeds.size:
        return
    length = float(np.median(speeds))
    is_fastest = all(length >= SATURATED * one.limit for one in calls)
    what = (
        'are always saturated at the speed limit. Is the gain far too large, or the length fixed?'
        if is_fastest
        else f'all have the length {length:.2g} m/s. Is the length fixed?'
    )
    hint = f'{YOURS} have the right directions, but {what}'
    answers = [saturated(1e6 * one.solution, length) for one in calls]
    yield from tried(hint, calls, answers, is_multiple=True)
