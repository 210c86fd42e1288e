"""The format `classroom50`: the marks of result.json of Classroom 50, and the autograder.

Fields as in the wiki of foundation50/classroom50, Advanced Autograding; the autograder adds those
that tell whose submission it is. Scores are integers there: hundredths of the rubric's points.
"""

from __future__ import annotations

from typing import Any

from setcmas_tools.grade_formats.bundles.kit import Kit
from setcmas_tools.grade_formats.feedback import criteria_texts
from setcmas_tools.grade_formats.format import Files, GradeFormat, result_files
from setcmas_tools.grading.marks import Marks

_HUNDREDTHS = 100


def _result(marks: Marks) -> dict[str, Any]:
    tests: list[dict[str, Any]] = [
        {
            'test-name': f'{scenario.name}: {mark.name}',
            'passed': mark.is_full,
            'score': round(mark.points * _HUNDREDTHS),
            'max-score': round(mark.max_points * _HUNDREDTHS),
            'output': text,
        }
        for scenario in marks.scenarios
        for mark, text in criteria_texts(scenario)
    ]
    return {
        'schema': 'classroom50/result/v1',
        'score': sum(test['score'] for test in tests),
        'max-score': sum(test['max-score'] for test in tests),
        'tests': tests,
    }


def _bundle(kit: Kit) -> Files:
    return {**kit.filled_in('classroom50'), **kit.files}


CLASSROOM50 = GradeFormat(
    'Classroom 50: result.json; --make writes the autograder',
    result_files('classroom50', _result),
    _bundle,
)
