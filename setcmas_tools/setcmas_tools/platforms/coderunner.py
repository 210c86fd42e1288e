"""The format `coderunner`: what a combinator template grader of Moodle's CodeRunner prints.

Fields as in CodeRunner's documentation, section Combinator-template grading.
"""

from __future__ import annotations

from html import escape
from typing import Any

from setcmas_tools.grade.criteria import points_text
from setcmas_tools.grade.mark_pages import share
from setcmas_tools.grade.mark_pictures import picture_address
from setcmas_tools.grade.marks import CriterionMark, Marks, ScenarioMark
from setcmas_tools.platforms.autograder import Kit, archive
from setcmas_tools.platforms.grade_format import (
    Files,
    GradeFormat,
    failure_text,
    result_files,
    summary,
)

_DIGITS = 9  # Moodle multiplies by the question's grade, and rounds to two decimals
_HEADER = ['iscorrect', 'Scenario', 'Criterion', 'Wanted', 'Reached', 'Points', 'Hint']


def _result(marks: Marks) -> dict[str, Any]:
    rows = [_row(one, mark) for one in marks.scenarios for mark in one.criteria]
    failures = [summary(marks)]
    failures += [failure_text(one.failure) for one in marks.scenarios if one.failure]
    return {
        'fraction': round(share(marks.score, marks.max_score), _DIGITS),
        'prologuehtml': ''.join(f'<pre>{escape(text)}</pre>' for text in failures if text),
        'testresults': [_HEADER, *rows],
        'epiloguehtml': ''.join(map(_picture, marks.scenarios)),
    }


def _row(scenario: ScenarioMark, mark: CriterionMark) -> list[str | int]:
    """Return a row; CodeRunner escapes its cells."""
    points = f'{points_text(mark.points)} of {points_text(mark.max_points)}'
    reached = '' if mark.hidden else mark.reached_text
    return [int(mark.is_full), scenario.name, mark.name, mark.wanted, reached, points, mark.hint]


def _picture(scenario: ScenarioMark) -> str:
    address, name = picture_address(scenario.paths, scenario.name), escape(scenario.name)
    return f'<p>{name}</p><img alt="{name}" src="{address}">' if address else ''


def _bundle(kit: Kit) -> Files:
    rubric = {path: content for path, content in kit.files.items() if path not in kit.wheels}
    return {
        **kit.filled_in('coderunner'),
        'rubric.zip': archive(rubric),
        **kit.wheels,
    }


CODERUNNER = GradeFormat(
    'Moodle CodeRunner: the JSON of a template grader; --make writes the template',
    result_files('coderunner', _result),
    _bundle,
)
