"""Diagnosis of a submission: the one mistake that reproduces what its robots did, or none."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_tools.compare.generic_mistakes import (
    ANSWERS,
    BODY,
    FACTORS,
    POLAR,
    SAME_TIME,
    TURNED,
    in_body_frame,
    polar,
)
from setcmas_tools.offline.altered_solutions import (
    CLOSE,
    FROZEN,
    RIGHT,
    SOLUTION,
    Altered,
    Calls,
    Mistake,
    altered_solutions,
    calls_of,
    saturated,
    twice_altered_solutions,
)
from setcmas_tools.run.run import Run
from setcmas_tools.scenario.scenario import Scenario

_LEFT = 0.1
"""Share of the calls unlike the solution's that an explanation may leave unexplained."""
_TIED = 0.005  # share of all calls by which the better one must be better
_FEWEST = 10  # calls to estimate a factor from
_EQUAL = 0.02  # relative difference of factors


class Diagnosis(NamedTuple):
    """The hint of the one mistake that reproduces a submission; otherwise, how it differs."""

    explanation: str = ''
    measured: str = ''


def diagnosis(
    runs: Sequence[tuple[str, Scenario, Run]],
    solution: Path | None,
    mistakes: Sequence[Mistake],
    is_condition: bool = False,
) -> Diagnosis:
    """Return the diagnosis of a submission.

    Args:
        runs: Names of scenarios, these without a law, and the complete runs of the submission.
        solution: Script of the solution; None is the default condition, or no solution.
        mistakes: Typical mistakes; they run in this process, as the solution does.
        is_condition: Whether the submission is a triggering condition; else a control law.
    """
    if (not is_condition and not solution) or any(run.info.started for *_, run in runs):
        return Diagnosis()
    with (
        TemporaryDirectory(prefix='setcmas_') as folder,
        suppress(SetcmasError),
        np.errstate(all='ignore'),
    ):
        once = altered_solutions(solution, mistakes, is_condition, Path(folder))
        calls = _calls(runs, is_condition, once)
        explanation = _explanation(calls, mistakes, is_condition) if calls else ''
        if calls and not explanation and solution and not is_condition:
            twice = twice_altered_solutions(solution, mistakes, Path(folder))
            explanation = _two_mistakes(_calls(runs, is_condition, twice), mistakes)
        return Diagnosis(explanation, '' if explanation else _measured(calls, is_condition))
    return Diagnosis()


def _calls(
    runs: Sequence[tuple[str, Scenario, Run]], is_condition: bool, altered: Sequence[Altered]
) -> list[Calls]:
    """Return the calls of all runs; none if a run cannot be repeated."""
    found = [calls_of(*each, is_condition, altered) for each in runs]
    return [one for one in found if one] if all(found) else []


class _Explanation(NamedTuple):
    """A possible hint, and the number of calls of all scenarios that do not agree with it."""

    hint: str
    differing: int


def _explanation(calls: Sequence[Calls], mistakes: Sequence[Mistake], is_condition: bool) -> str:
    """Return the hint of the one best explanation; '' for none, or for several as good.

    What the lecturer lists comes first; of the others, those with fewer numbers to fit.
    """
    generic = _generic_laws if not is_condition else _generic_conditions
    for candidates in (_listed(calls, mistakes), generic(calls), _scaled(calls, is_condition)):
        if best := _best(calls, candidates):
            return best
    return ''


def _best(calls: Sequence[Calls], candidates: Iterable[_Explanation]) -> str:
    found = sorted(candidates, key=lambda one: one.differing)
    margin = _TIED * sum(one.own.shape[0] * one.own.shape[1] for one in calls)
    hints = {one.hint for one in found if one.differing <= found[0].differing + margin}
    return hints.pop() if len(hints) == 1 else ''


def _two_mistakes(calls: Sequence[Calls], mistakes: Sequence[Mistake]) -> str:
    """Return the hints of two mistakes that together explain a submission; '' for none."""
    groups = (_both_listed, _also(_generic_laws), _also(_multiple), _also(_plain_multiple))
    return next(filter(None, (_best(calls, group(calls, mistakes)) for group in groups)), '')


def _both_listed(calls: Sequence[Calls], mistakes: Sequence[Mistake]) -> Iterator[_Explanation]:
    for name in _known(calls):
        if ' ' in name:
            one, other = (mistakes[int(number)].hint for number in name.split())
            answers = [each.answers[name] for each in calls]
            yield from _tried(f'Two mistakes: {one} {other}', calls, answers)


def _also(
    generic: Callable[[Sequence[Calls]], Iterator[_Explanation]],
) -> Callable[[Sequence[Calls], Sequence[Mistake]], Iterator[_Explanation]]:
    """Return a function that yields explanations by a listed mistake and a generic one."""

    def both(calls: Sequence[Calls], mistakes: Sequence[Mistake]) -> Iterator[_Explanation]:
        for name in filter(str.isdigit, _known(calls)):
            altered = [
                replace(one, answers={SOLUTION: one.answers[name], RIGHT: one.solution})
                for one in calls
            ]
            for hint, differing in generic(altered):
                text = f'Two mistakes: {mistakes[int(name)].hint} {hint}'
                yield _Explanation(text, differing)

    return both


def _known(calls: Sequence[Calls]) -> list[str]:
    """Return the names of the altered solutions that are not given up in any scenario."""
    return sorted(set.intersection(*(set(one.answers) for one in calls)))


def _listed(calls: Sequence[Calls], mistakes: Sequence[Mistake]) -> Iterator[_Explanation]:
    for number, mistake in enumerate(mistakes):
        answers = [one.answers.get(str(number)) for one in calls]
        yield from _tried(mistake.hint, calls, answers)


def _tried(
    hint: str, calls: Sequence[Calls], answers: Sequence[Floats | None], is_multiple: bool = False
) -> Iterator[_Explanation]:
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
        yield _Explanation(hint, after)


def _generic_laws(calls: Sequence[Calls]) -> Iterator[_Explanation]:
    yield from _tried(SAME_TIME, calls, [one.answers.get(FROZEN) for one in calls])
    who, wrong = _wrong_robots(calls)
    for hint, turned in TURNED:
        answers = [np.stack(turned(*np.moveaxis(one.solution, -1, 0)), -1) for one in calls]
        for one, answer, other in zip(calls, answers, wrong, strict=True):
            answer[:, ~other] = one.solution[:, ~other]
        yield from _tried(f'{who}{hint}', calls, answers, is_multiple=True)
    for sign in (1, -1):
        answers = [in_body_frame(one, sign) for one in calls]
        yield from _tried(BODY, calls, answers, is_multiple=True)
    for returned in zip(*(polar(one) for one in calls), strict=True):
        yield from _tried(POLAR, calls, returned, is_multiple=True)


def _wrong_robots(calls: Sequence[Calls]) -> tuple[str, list[NDArray[np.bool_]]]:
    """Return text on which robots differ from the solution; '' and all of them if it varies."""
    wrong = [one.differs(one.solution).mean(axis=0) > one.may_differ for one in calls]
    for title, robots in (
        (
            'Of all robots, only {} differ{s}. ',
            [tuple((np.flatnonzero(one) + 1).tolist()) for one in wrong],
        ),
        ('Only {} {is} right. ', [tuple((np.flatnonzero(~one) + 1).tolist()) for one in wrong]),
    ):
        if robots[0] and len(set(robots)) == 1 and not all(map(np.all, wrong)):
            return _named(title, robots[0]), wrong
    return '', [np.ones_like(one) for one in wrong]


def _named(title: str, robots: Sequence[int]) -> str:
    names = f'robot{"s" * (len(robots) > 1)} {", ".join(map(str, robots))}'
    return title.format(
        names, **({'s': '', 'is': 'are'} if len(robots) > 1 else {'s': 's', 'is': 'is'})
    )


def _generic_conditions(calls: Sequence[Calls]) -> Iterator[_Explanation]:
    for hint, changed in ANSWERS:
        answers = [
            np.stack([changed(one.solution[..., 0]), one.solution[..., 1]], -1) for one in calls
        ]
        found = [*_tried(hint, calls, answers)]
        if found:
            yield from found
            return


def _scaled(calls: Sequence[Calls], is_condition: bool) -> Iterator[_Explanation]:
    """Yield explanations by a number: the first kind that fits counts."""
    kinds = (
        (_multiple, _constants, _plain_multiple, _too_fast) if not is_condition else (_distance,)
    )
    for kind in kinds:
        found = [*kind(calls)]
        if found:
            yield from found
            return


def _multiple(calls: Sequence[Calls]) -> Iterator[_Explanation]:
    """Yield the explanation by a factor that has a name."""
    factors = [_factor(one, one.solution) for one in calls]
    sizes = [one.own.shape[1] for one in calls]
    known = [place for place, factor in enumerate(factors) if math.isfinite(factor)]
    found = [factors[place] for place in known]
    for name, of_size in FACTORS.items():
        if known and min(sizes) > 1 and _are_equal(found, [of_size(sizes[i]) for i in known]):
            text = f'{name}, where N is the number of robots' if 'N' in name else name
            if 'N' in name and len({sizes[place] for place in known}) == 1:
                text = f'{found[0]:.3g}, which is {text}'  # it may be another number
            yield from _by_factors(calls, [of_size(size) for size in sizes], text)


def _plain_multiple(calls: Sequence[Calls]) -> Iterator[_Explanation]:
    factors = [_factor(one, one.solution) for one in calls]
    if np.isfinite(factors).all() and _are_equal(factors, factors[:1] * len(factors)):
        yield from _by_factors(calls, factors, f'{factors[0]:.3g}')


def _by_factors(
    calls: Sequence[Calls], factors: Sequence[float], name: str
) -> Iterator[_Explanation]:
    answers = [factor * one.solution for factor, one in zip(factors, calls, strict=True)]
    hint = (
        f'Your velocities have the right directions, but their lengths are multiplied by {name}.'
    )
    yield from _tried(hint, calls, answers, is_multiple=True)


def _factor(calls: Calls, direction: Floats, start: Floats | None = None) -> float:
    """Return the x for which the submission is start + x * direction; NaN if unknown."""
    moves = np.hypot(direction[..., 0], direction[..., 1]) > CLOSE / 10
    free = calls.is_free & moves
    if free.sum() < _FEWEST:
        return math.nan
    own = calls.own[free] if start is None else calls.own[free] - start[free]
    along = direction[free]
    return float(np.median((own * along).sum(-1) / (along * along).sum(-1)))


def _are_equal(factors: Sequence[float], others: Sequence[float]) -> bool:
    return bool(np.allclose(factors, others, rtol=_EQUAL, atol=1e-6))


def _constants(calls: Sequence[Calls]) -> Iterator[_Explanation]:
    """Yield explanations by another value of a constant, in which the law must be affine."""
    for name in set.intersection(*(set(one.values) for one in calls)):
        steps = [one.answers[name] - one.solution for one in calls]
        shares = [_factor(one, step, one.solution) for one, step in zip(calls, steps, strict=True)]
        known = [1 + share for share in shares if math.isfinite(share)]
        ratios = [0.0, -1.0]
        if known and _are_equal(known, [known[0]] * len(known)):
            ratios = [*(one for one in ratios if not _are_equal([one], known[:1])), known[0]]
        value = calls[0].values[name]
        for ratio in ratios:
            answers = [
                one.solution + (ratio - 1) * step for one, step in zip(calls, steps, strict=True)
            ]
            hint = _constant_hint(name, value * ratio, value)
            yield from _tried(hint, calls, answers, is_multiple=True)


def _constant_hint(name: str, found: float, right: float) -> str:
    if abs(found) < _EQUAL * abs(right):
        return f'Your robots move as if {name} were 0: the term with {name} has no effect.'
    if abs(found + right) < _EQUAL * abs(right):
        return f'The term with {name} has the wrong sign; the rest is right.'
    return f'Your robots move as if {name} were {found:.3g}, not {right:g}; the rest is right.'


def _too_fast(calls: Sequence[Calls]) -> Iterator[_Explanation]:
    """Yield the explanation of a law that is saturated all the time, in the right direction."""
    hint = (
        'Your velocities have the right directions, but the robots always move at the speed '
        'limit, as with a gain that is far too large.'
    )
    yield from _tried(hint, calls, [1e6 * one.solution for one in calls], is_multiple=True)


def _distance(calls: Sequence[Calls]) -> Iterator[_Explanation]:
    """Yield the explanation of a condition with another distance than the right one."""
    gone = np.concatenate([one.heading.ravel() for one in calls])
    sends = np.concatenate([one.own[..., 0].ravel() for one in calls]) == 1
    if not sends.any() or sends.all():
        return
    least = float(gone[sends].min())
    answers = []
    for one in calls:
        answer = np.zeros_like(one.own)
        answer[..., 0] = one.heading >= least
        answers.append(answer)
    right = min(one.heading[one.solution[..., 0] == 1].min(initial=np.inf) for one in calls)
    limit = f'from {right:.2g} m on' if math.isfinite(right) else 'from further on'
    hint = (
        f'Your condition holds from a distance of {least:.2g} m to the last position sent on, '
        f'as with another THRESHOLD; the right one {limit}.'
    )
    yield from _tried(hint, calls, answers)


def _measured(calls: Sequence[Calls], is_condition: bool) -> str:
    """Return where a submission first differs from the solution."""
    for one in calls:
        differs = one.differs(one.solution)
        if not is_condition:
            differs = differs[:-2] & differs[1:-1] & differs[2:]  # for more than a call or two
        for call, robot in np.argwhere(differs)[:1].tolist():
            return _difference(one, call, robot, is_condition)
    return ''


def _difference(calls: Calls, call: int, robot: int, is_condition: bool) -> str:
    only = _wrong_robots([calls])[0]
    (vx, vy), seen = calls.own[call, robot], calls.heading[call, robot]
    right = saturated(calls.solution[call, robot], calls.limit)
    text = (
        f'its velocity is ({vx:.2g}, {vy:.2g}) m/s; from the same place, the right one is '
        f'({right[0]:.2g}, {right[1]:.2g}) m/s'
    )
    if is_condition:
        text = f'it {"sends" if vx else "does not send"}, {seen:.2g} m from the position sent last'
    first = f"In '{calls.name}', robot {robot + 1} first differs from the solution at"
    return f'{first} t = {calls.t[call]:.1f} s: {text}. {only}'.rstrip()
