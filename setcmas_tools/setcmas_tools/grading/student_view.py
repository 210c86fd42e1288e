"""Marks as students may see them: without what the rubric hides, and without other students."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from setcmas_tools.grading.marks import CriterionMark, Marks, ScenarioMark

_DIGITS = 4  # of points, as in marks


def student_view(marks: Marks) -> Marks:
    """Return marks of which students may see everything; scores stay what they are.

    Hidden criteria of a scenario become one without a figure, hidden scenarios become one with
    one criterion.
    """
    shown = [_without_hidden(one) for one in marks.scenarios if not one.hidden]
    hidden = [mark for one in marks.scenarios if one.hidden for mark in one.criteria]
    if hidden:
        together = (_together(hidden, 'all hidden scenarios'),)
        shown.append(ScenarioMark('Hidden scenarios', together, hidden=True))
    return replace(marks, scenarios=tuple(shown), similar=(), digest='')


def _without_hidden(scenario: ScenarioMark) -> ScenarioMark:
    shown = [mark for mark in scenario.criteria if not mark.hidden]
    hidden = [mark for mark in scenario.criteria if mark.hidden]
    if hidden:
        shown.append(_together(hidden, 'hidden criteria'))
    return replace(scenario, criteria=tuple(shown))


def _together(criteria: Sequence[CriterionMark], name: str) -> CriterionMark:
    points = round(sum(mark.points for mark in criteria), _DIGITS)
    most = round(sum(mark.max_points for mark in criteria), _DIGITS)
    return CriterionMark(name, points, most, '', '', None, hidden=True)
