"""Marks of a student in words, for platforms that show text."""

from __future__ import annotations

from collections.abc import Iterator

from setcmas_tools.grading.marks import CriterionMark, Failure, Marks, ScenarioMark
from setcmas_tools.grading.pages.remarks import failure_line, points_text

UNFILLED = 'Not filled in yet: this is the exercise as it was handed out.'


def summary(marks: Marks) -> str:
    """Return what there is to say of a submission as a whole; may be empty."""
    told = [UNFILLED] if marks.unfilled else []
    return '\n'.join(told + ([failure_text(marks.failure)] if marks.failure else []))


def criteria_texts(scenario: ScenarioMark) -> Iterator[tuple[CriterionMark, str]]:
    """Yield each criterion with its figures and hint; the first tells of a failure, too."""
    failed = [failure_text(scenario.failure)] if scenario.failure else []
    for mark in scenario.criteria:
        yield mark, '\n'.join(filter(None, [*failed, criterion_text(mark)]))
        failed = []


def criterion_text(mark: CriterionMark) -> str:
    """Return figures and hint of a criterion; may be empty."""
    figures = '' if mark.hidden else f'wanted {mark.wanted}, reached {mark.reached_text}'
    return '\n'.join(filter(None, (figures, mark.hint)))


def failure_text(failure: Failure) -> str:
    """Return what went wrong with the lines of the script around it."""
    if not failure.line:
        return failure.message
    lines = [
        f'{">" if number == failure.line else " "} {number:4} {text}'
        for number, text in enumerate(failure.around, start=failure.first)
    ]
    return '\n'.join([failure_line(failure), *lines])


def feedback(marks: Marks) -> str:
    """Return all that a student is to read of a submission."""
    lines = [summary(marks)] if summary(marks) else []
    for scenario in marks.scenarios:
        lines.append(_line(scenario.name, scenario.points, scenario.max_points))
        for mark, text in criteria_texts(scenario):
            sign = '✓' if mark.is_full else '✗'
            lines.append(f'{sign} {_line(mark.name, mark.points, mark.max_points)}')
            lines += [text] if text else []
    return '\n'.join(lines)


def _line(name: str, points: float, most: float) -> str:
    return f'{name}: {points_text(points)} of {points_text(most)}'
