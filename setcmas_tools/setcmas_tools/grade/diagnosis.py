"""Diagnosis of a submission: the one mistake that reproduces what its robots did, or none."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function
from setcmas_tools.grade.altered_solutions import (
    Calls,
    altered_solutions,
    calls_of,
    saturated,
)
from setcmas_tools.grade.generic_mistakes import (
    EQUAL,
    YOURS,
    Explanation,
    fixed_length,
    generic_conditions,
    generic_conversions,
    generic_laws,
    named_multiple,
    other_constant,
    other_distance,
    other_turn_rate,
    plain_multiple,
    same_times,
    scaled_part,
    times_too,
    tried,
)
from setcmas_tools.grade.rubric import MarkedScenario, Rubric, TypicalMistake
from setcmas_tools.run.run import Run

_TIED = 0.005  # share of all calls by which the better one must be better


def diagnosis(rubric: Rubric, runs: Sequence[tuple[MarkedScenario, Run]], hint: str) -> str:
    """Return the hint of the one mistake that reproduces a submission.

    If there is none, return where the submission first differs from the solution, and its hint.

    Args:
        rubric: Its typical mistakes run in this process, as the solution does.
        runs: Scenarios and the complete runs of the submission.
        hint: The hint of the criterion that it has missed.
    """
    solution, mistakes, function = rubric.solution, rubric.mistakes, rubric.function
    is_unknown = rubric.references or (function is Function.CONTROL and not solution)
    if is_unknown or any(run.info.started for _, run in runs):
        return hint
    with (
        TemporaryDirectory(prefix='setcmas_') as folder,
        suppress(SetcmasError),
        np.errstate(all='ignore'),
    ):
        altered = altered_solutions(solution, mistakes, function, Path(folder))
        found = [calls_of(one.name, one.base, run, function, altered) for one, run in runs]
        if runs and all(found):  # else a run cannot be repeated
            calls = [one for one in found if one]
            explanation = _explanation(calls, mistakes, function)
            return explanation or f'{_measured(calls, function)} {hint}'.strip()
    return hint


def _explanation(
    calls: Sequence[Calls], mistakes: Sequence[TypicalMistake], function: Function
) -> str:
    """Return the hint of the one best explanation; '' for none, or for several as good.

    What the lecturer lists comes first; of the others, those with fewer numbers to fit, and those
    of all robots before those of some.
    """
    groups: list[Iterable[Explanation]] = [_listed(calls, mistakes)]
    if function is Function.CONDITION:
        groups += [generic_conditions(calls), other_distance(calls), same_times(calls)]
    elif function is Function.SI_TO_UNI:
        groups += [generic_conversions(calls), _terms(calls, mistakes, 'si_to_uni')]
        groups += [other_turn_rate(calls)]
    else:
        groups += [generic_laws(calls), named_multiple(calls), other_constant(calls)]
        groups += [_terms(calls, mistakes, 'law'), plain_multiple(calls), fixed_length(calls)]
        groups += [
            _some_robots(calls, each) for each in (generic_laws, plain_multiple, fixed_length)
        ]
    return next(filter(None, (_best_hint(calls, group) for group in groups)), '')


def _best_hint(calls: Sequence[Calls], candidates: Iterable[Explanation]) -> str:
    found = sorted(candidates, key=lambda one: one.differing)
    margin = _TIED * sum(one.own.shape[0] * one.own.shape[1] for one in calls)
    hints = {one.hint for one in found if one.differing <= found[0].differing + margin}
    return hints.pop() if len(hints) == 1 else ''


def _answered(
    calls: Sequence[Calls], mistakes: Sequence[TypicalMistake]
) -> Iterator[tuple[TypicalMistake, list[Floats]]]:
    """Yield mistakes that fail in no scenario, and what the solution answers with each."""
    for number, mistake in enumerate(mistakes):
        if all(str(number) in one.answers for one in calls):
            yield mistake, [one.answers[str(number)] for one in calls]


def _listed(calls: Sequence[Calls], mistakes: Sequence[TypicalMistake]) -> Iterator[Explanation]:
    for mistake, answers in _answered(calls, mistakes):
        yield from tried(mistake.hint, calls, answers)


def _some_robots(
    calls: Sequence[Calls], generic: Callable[[Sequence[Calls]], Iterable[Explanation]]
) -> Iterator[Explanation]:
    """Yield generic explanations of the robots that are wrong, if others are always right."""
    who, wrong = _wrong_robots(calls)
    some = [one.of_robots(own) for one, own in zip(calls, wrong, strict=True) if own.any()]
    for hint, differing in generic(some) if who else ():
        if hint.startswith(YOURS):
            yield Explanation(hint.replace(YOURS, f'The velocities of {who}', 1), differing)


def _wrong_robots(calls: Sequence[Calls]) -> tuple[str, list[NDArray[np.bool_]]]:
    """Return a name of the robots that are wrong, and which they are; '' if none is right."""
    found = [one.differs(one.solution).mean(axis=0) > one.may_differ for one in calls]
    size = max(one.size for one in found)
    is_wrong = np.zeros(size, dtype=bool)
    for one in found:
        is_wrong[: one.size] |= one
    wrong, right = np.flatnonzero(is_wrong) + 1, np.flatnonzero(~is_wrong) + 1
    name = '' if not right.size or not wrong.size else _named(wrong)
    if name and right.size < wrong.size:
        name = f'all robots but {_named(right)}'
    return name, [is_wrong[: one.size] for one in found]


def _named(robots: NDArray[np.int_]) -> str:
    return f'robot{"s" * (robots.size > 1)} {", ".join(map(str, robots))}'


def _terms(
    calls: Sequence[Calls], mistakes: Sequence[TypicalMistake], what: str
) -> Iterator[Explanation]:
    """Yield explanations by the factor of a term, which a mistake leaves out."""
    for mistake, rest in _answered(calls, mistakes):
        if mistake.term:
            part = [one.solution - each for one, each in zip(calls, rest, strict=True)]
            hint_of = partial(_term_hint, f'In your {what}, {mistake.term}', calls[0].values)
            yield from scaled_part(hint_of, calls, rest, part)


def _term_hint(begin: str, constants: Mapping[str, float], factor: float) -> str:
    sign = ' has the wrong sign, and' if factor < 0 else ''
    size = abs(factor)
    if abs(size - 1) < EQUAL:
        return f'{begin} has the wrong sign; the rest is right.'
    question = '; the rest is right.'
    for name, value in constants.items():
        if value % 1 and abs(size * value - 1) < EQUAL:
            question = f': is {name} missing?'
        elif value % 1 and abs(size / value - 1) < EQUAL:
            question = f': does {name} multiply it, too?'
    return f'{begin}{sign} is {times_too(size)}{question}'


def _measured(calls: Sequence[Calls], function: Function) -> str:
    """Return where a submission first differs from the solution."""
    for one in calls:
        differs = one.differs(one.solution)
        if function is not Function.CONDITION:
            differs = differs[:-2] & differs[1:-1] & differs[2:]
        for call, robot in np.argwhere(differs)[:1].tolist():
            return _difference(one, call, robot, function)
    return ''


def _difference(calls: Calls, call: int, robot: int, function: Function) -> str:
    who, own = _wrong_robots([calls])[0], calls.own[call, robot]
    right = saturated(calls.solution[call, robot], calls.limit)
    if function is Function.CONDITION:
        does = 'sends' if own[0] else 'does not send'
        text = f'it {does} {calls.distance_to_sent[call, robot]:.2g} m from the last position sent'
    elif function is Function.SI_TO_UNI:
        text = _answers('it returns', 'answer', 'V = {:.2g} m/s, omega = {:.2g} rad/s', own, right)
    else:
        text = _answers('its velocity is', 'one', '({:.2g}, {:.2g}) m/s', own, right)
    longer = '' if function is Function.CONDITION else ' for more than two calls'
    first = f"In '{calls.name}', robot {robot + 1} first differs from the solution{longer} at"
    only = '' if who.startswith('all') else 'only '
    affected = f' This affects {only}{who}.' if who else ''
    return f'{first} t = {calls.t[call]:.1f} s: {text}.{affected}'


def _answers(begin: str, what: str, form: str, *answers: Floats) -> str:
    own, right = (form.format(*np.round(one, 3) + 0.0) for one in answers)  # no -0
    return f'{begin} {own}; from the same place, the right {what} is {right}'
