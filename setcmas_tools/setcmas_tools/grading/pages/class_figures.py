"""Figures of a graded class: distribution, criteria from the hardest on, likenesses."""

from __future__ import annotations

import statistics
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

from setcmas_tools.grading.marks import CriterionMark, Marks

_BINS = 10


@dataclass(frozen=True)
class CriterionFigures:
    """How a class did in one criterion.

    Attributes:
        scenario: Name of the scenario.
        name: Name of the criterion.
        share: Mean share of its points, from 0 to 1.
        full: How many submissions have all of them.
        hidden: Whether students see nothing of it but its points.
    """

    scenario: str
    name: str
    share: float
    full: int
    hidden: bool


@dataclass(frozen=True)
class Likeness:
    """Submissions that are like each other, or like a shipped law.

    Attributes:
        one: A submission.
        other: Another one, or 'the shipped law NAME'.
        share: How much is the same, from 0 to 1.
    """

    one: str
    other: str
    share: float


def has_failed(marks: Marks) -> bool:
    """Return whether a script failed in some scenario, or could not be run."""
    return bool(marks.failure or any(one.failure for one in marks.scenarios))


def share(points: float, most: float) -> float:
    """Return a share of points; all of none is 1."""
    return points / most if most else 1.0


def bins(marks: Sequence[Marks]) -> list[int]:
    """Return numbers of submissions by share of the points, in steps of 10 %."""
    counts = [0] * _BINS
    for one in marks:
        counts[min(int(share(one.score, one.max_score) * _BINS), _BINS - 1)] += 1
    return counts


def hardest_first(marks: Sequence[Marks]) -> list[CriterionFigures]:
    """Return criteria, from the one with the smallest share of points on."""
    found: dict[tuple[str, str], list[CriterionMark]] = defaultdict(list)
    hidden: dict[tuple[str, str], bool] = {}
    for one in marks:
        for scenario in one.scenarios:
            for mark in scenario.criteria:
                found[scenario.name, mark.name].append(mark)
                hidden[scenario.name, mark.name] = scenario.hidden or mark.hidden
    figures = [
        CriterionFigures(
            *key,
            statistics.fmean(share(mark.points, mark.max_points) for mark in of_key),
            sum(mark.is_full for mark in of_key),
            hidden[key],
        )
        for key, of_key in found.items()
    ]
    return sorted(figures, key=lambda one: one.share)


def likeness_pairs(marks: Sequence[Marks]) -> list[Likeness]:
    """Return what is like something else, from the strongest likeness on, each pair once."""
    ours = {one.submission for one in marks}
    pairs: dict[tuple[str, str], float] = {}
    for one in marks:
        for similar in one.similar:
            key = (one.submission, similar.submission)
            if similar.submission in ours:  # each tells of the other
                key = (min(key), max(key))
            pairs[key] = max(pairs.get(key, 0.0), similar.share)
    ordered = sorted(pairs.items(), key=lambda pair: (-pair[1], pair[0]))
    return [Likeness(*key, value) for key, value in ordered]
