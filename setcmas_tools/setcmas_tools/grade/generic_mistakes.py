"""Generic mistakes of laws, conditions and si_to_uni, and which of them reproduce a submission."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

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
_SMALLEST = 1e-4  # factor; smaller ones are as good as 0
_AT_ONCE_M = 0.006  # at 0.1 m/s after less than a step

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

CONDITIONS: tuple[tuple[str, Callable[[Floats], Floats]], ...] = (
    (
        'Your condition always holds, so the robots send every time. Is the comparison the right '
        'way round?',
        np.ones_like,
    ),
    (
        'Your condition never holds, so the robots send only their first state. Does it compare p '
        'with p_sent, in m?',
        np.zeros_like,
    ),
    ('Your condition is the opposite of the right one: check the comparison.', lambda x: 1 - x),
)
"""What a condition does, and the function that makes its answers of the right ones."""

MOVED_AT_ALL = (
    'Your condition holds as soon as the robot has moved at all. Do you compare the distance with '
    'THRESHOLD?'
)
SAME_TIMES = (
    'Your condition holds for all robots at the same times, wherever they are. Compare the '
    'distance to p_sent, not the time.'
)
FACTORS: dict[str, Callable[[float], float]] = {
    'N': lambda n: n,
    'N-1': lambda n: n - 1,
    'N/(N-1)': lambda n: n / (n - 1),
    'N squared': lambda n: n * n,
    '180/pi': lambda _: 180 / math.pi,
}
"""Factors by name, above 1, for fleets of N robots; they multiply or divide."""


BODY = (
    f'{YOURS} are turned by the heading of the robot. Return vx and vy in the world frame: they '
    'do not depend on the heading.'
)
IN_DEGREES = (
    f'{YOURS} have the right lengths, but not the right directions: sin and cos of an angle in '
    'degrees. They take radians.'
)


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


def turned(velocities: Floats, angles: Floats) -> Floats:
    """Return velocities, shape (..., 2), turned by angles in rad."""
    complex_numbers = velocities @ np.array([1, 1j]) * np.exp(1j * angles)
    return np.stack([complex_numbers.real, complex_numbers.imag], -1)


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
        answers = [one.solution @ np.transpose(matrix) for one in calls]
        yield from tried(f'{YOURS} are {what}', calls, answers, is_multiple=True)
    for sign in (1, -1):
        answers = [turned(one.solution, sign * one.heading) for one in calls]
        yield from tried(BODY, calls, answers, is_multiple=True)
    angles = [np.arctan2(one.solution[..., 1], one.solution[..., 0]) for one in calls]
    answers = [
        turned(one.solution, np.degrees(angle) - angle)
        for one, angle in zip(calls, angles, strict=True)
    ]
    yield from tried(IN_DEGREES, calls, answers, is_multiple=True)
    for returned in zip(*(polar(one) for one in calls), strict=True):
        yield from tried(POLAR, calls, returned, is_multiple=True)


def generic_conditions(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield the explanation of a condition that always or never holds, or is the opposite."""
    for hint, changed in CONDITIONS:
        found = [*tried(hint, calls, [_sending(changed(one.solution[..., 0])) for one in calls])]
        if found:  # the first that fits counts
            yield from found
            return


def other_distance(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield the explanation of a condition with another distance than the right one."""
    distances = np.concatenate([one.distance_to_sent.ravel() for one in calls])
    sends = np.concatenate([one.own[..., 0].ravel() for one in calls]) == 1
    if not sends.any() or sends.all():
        return
    least = float(distances[sends].min())
    right = min(
        one.distance_to_sent[one.solution[..., 0] == 1].min(initial=np.inf) for one in calls
    )
    wanted = (
        f'it must hold only beyond {right:.2g} m' if math.isfinite(right) else 'that is too early'
    )
    hint = (
        f'Your condition holds as soon as the robot is {least:.2g} m away from the last position '
        f'sent; {wanted}. Check THRESHOLD and its unit.'
    )
    answers = [_sending(one.distance_to_sent >= least) for one in calls]
    yield from tried(MOVED_AT_ALL if least < _AT_ONCE_M else hint, calls, answers)


def same_times(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield the explanation of a condition that holds for all robots at the same times."""
    answers = [
        np.broadcast_to(np.median(one.own, axis=1, keepdims=True), one.own.shape) for one in calls
    ]
    if all(one.own.shape[1] > 2 for one in calls):
        yield from tried(SAME_TIMES, calls, answers)


def _sending(holds: NDArray[Any]) -> Floats:
    """Return the answers of a condition that holds or not at each call of each robot."""
    return np.stack([holds, np.zeros(holds.shape)], -1)


def generic_conversions(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield explanations of a si_to_uni whose V and omega are swapped, zero, or of wrong sign."""
    for hint, matrix in COMMANDS:
        answers = [one.solution @ np.transpose(matrix) for one in calls]
        yield from tried(hint, calls, answers, is_multiple=True)


def other_turn_rate(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield the explanation of a si_to_uni whose turn rate is wrong by a factor."""
    speeds = [one.solution * (1.0, 0.0) for one in calls]
    turn_rates = [one.solution * (0.0, 1.0) for one in calls]
    yield from scaled_part(_turn_rate_hint, calls, speeds, turn_rates)


def _turn_rate_hint(factor: float) -> str:
    sign = ' and has the wrong sign' if factor < 0 else ''
    return f'V is right, but your turn rate is {times_too(abs(factor))}{sign}.'


def times_too(size: float) -> str:
    """Return by which factor something is too large or too small, such as '3 times too large'."""
    return f'{size:.3g} times too large' if size > 1 else f'{1 / size:.3g} times too small'


def named_multiple(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield explanations by a factor of the velocities that has a name."""
    factors = np.array([_multiple(one, one.own, one.solution) for one in calls])
    sizes = np.array([one.scenario.nb_robots for one in calls])
    known = np.isfinite(factors)
    if not known.any() or sizes.min() < 2:
        return
    for name, of_size in FACTORS.items():
        large = np.array([of_size(size) for size in sizes])
        for wanted in (large, 1.0 / large):
            if _are_equal(factors[known], wanted[known]):
                names = [name, ', where N is the number of robots'] if 'N' in name else [name, '']
                if 'N' in name and len({*sizes[known]}) == 1:
                    # It may be another number.
                    names = [f'{of_size(sizes[known][0]):.3g}', f' ({name} for N robots)']
                yield from _by_factors(calls, wanted, *names)


def plain_multiple(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield the explanation by any factor of the velocities, the same in all scenarios."""
    for factor in _shared([_multiple(one, one.own, one.solution) for one in calls]):
        size = abs(factor)
        yield from _by_factors(calls, [factor] * len(calls), f'{max(size, 1 / size):.3g}')


def _by_factors(
    calls: Sequence[Calls], factors: Sequence[float] | Floats, name: str, explained: str = ''
) -> Iterator[Explanation]:
    answers = [factor * one.solution for factor, one in zip(factors, calls, strict=True)]
    size = 'large' if abs(factors[0]) > 1 else 'small'
    ways = (
        'the right directions, but are' if factors[0] > 0 else 'the opposite directions, and are'
    )
    hint = f'{YOURS} have {ways} {name} times too {size}{explained}.'
    yield from tried(hint, calls, answers, is_multiple=True)


def other_constant(calls: Sequence[Calls]) -> Iterator[Explanation]:
    """Yield explanations by another value of a constant, in which the law must be affine."""
    for name in set.intersection(*(set(one.values) for one in calls)):
        steps = [one.answers[name] - one.solution for one in calls]  # the constant is doubled
        rest = [one.solution - step for one, step in zip(calls, steps, strict=True)]
        hint_of = partial(_constant_hint, name, calls[0].values[name])
        yield from scaled_part(hint_of, calls, rest, steps, (0.0, -1.0), is_multiple=True)


def _constant_hint(name: str, right: float, ratio: float) -> str:
    if abs(ratio) < EQUAL:
        return f'Your robots move as if {name} were 0: the term with {name} has no effect.'
    if abs(ratio + 1) < EQUAL:
        return f'The term with {name} has the wrong sign; the rest is right.'
    found = f'{ratio * right:.3g}, not {right:g}'
    return f'Your robots move as if {name} were {found}; the rest is right.'


def scaled_part(
    hint_of: Callable[[float], str],
    calls: Sequence[Calls],
    rest: Sequence[Floats],
    part: Sequence[Floats],
    further: Iterable[float] = (),
    is_multiple: bool = False,
) -> Iterator[Explanation]:
    """Yield explanations by a factor of a part of the right answers: measured, and some further.

    `hint_of` returns the hint for a factor.
    """
    factors = [_factor(*each) for each in zip(calls, rest, part, strict=True)]
    for factor in (*further, *_shared(factors)):
        answers = [one + factor * other for one, other in zip(rest, part, strict=True)]
        yield from tried(hint_of(factor), calls, answers, is_multiple)


def _shared(factors: Sequence[float]) -> list[float]:
    """Return the factor that those of all scenarios are, unless it varies, is 0 or unknown."""
    known = np.array(factors)[np.isfinite(factors)]
    is_one = known.size and abs(known[0]) > _SMALLEST and _are_equal(known, known[0])
    return [float(known[0])] if is_one else []


def _factor(calls: Calls, rest: Floats, part: Floats) -> float:
    """Return the x for which the submission is rest + x * part; NaN if unknown.

    Where the submission is saturated, only its direction is known.
    """
    found = _multiple(calls, calls.own - rest, part)
    if math.isfinite(found):
        return found
    across = _cross(calls.own, part)
    known = calls.is_known & (np.abs(across) > CLOSE * calls.limit)
    if known.sum() < _FEWEST:
        return math.nan
    return float(np.median(-_cross(calls.own, rest)[known] / across[known]))


def _multiple(calls: Calls, vectors: Floats, part: Floats) -> float:
    """Return the x for which vectors are x * part where no answer is saturated; NaN if unknown."""
    free = calls.is_free & (np.hypot(part[..., 0], part[..., 1]) > CLOSE / 10)
    if free.sum() < _FEWEST:
        return math.nan
    own, along = vectors[free], part[free]
    return float(np.median((own * along).sum(-1) / (along * along).sum(-1)))


def _cross(first: Floats, second: Floats) -> Floats:
    """Return the cross products of vectors, shape (..., 2)."""
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]


def _are_equal(factors: Floats, others: Floats | float) -> bool:
    return bool(np.allclose(factors, others, rtol=EQUAL, atol=1e-6))


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
