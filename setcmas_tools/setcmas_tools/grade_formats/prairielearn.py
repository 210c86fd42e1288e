"""The format `prairielearn`: results.json of an external grader, and a question with its image.

Fields as in PrairieLearn's docs/externalGrading.md; the file may have 1 MB.
"""

from __future__ import annotations

import json
from typing import Any

from setcmas_tools.grade_formats.bundles.kit import Kit
from setcmas_tools.grade_formats.feedback import criteria_texts, summary
from setcmas_tools.grade_formats.format import Files, GradeFormat, result_files
from setcmas_tools.grading.marks import Marks, ScenarioMark
from setcmas_tools.grading.pages.class_figures import share
from setcmas_tools.grading.pages.path_picture import picture_address

_MOST_BYTES = 900_000  # of 1 MB
_LONGEST_TEXT = 4000


def _result(marks: Marks) -> dict[str, Any]:
    """Return the result; what could not be run at all is no attempt, so it costs none."""
    told = summary(marks)
    if told:
        return {'gradable': False, 'score': 0.0, 'format_errors': [told[:_LONGEST_TEXT]]}
    result = {
        'gradable': True,
        'score': round(share(marks.score, marks.max_score), 4),
        'message': f'{marks.score:g} of {marks.max_score:g} points',
        'output': '',
        'images': [
            {'label': one.name, 'url': address}
            for one in marks.scenarios
            if (address := picture_address(one.paths, one.name))
        ],
        'tests': [test for one in marks.scenarios for test in _tests(one)],
    }
    if len(json.dumps(result)) > _MOST_BYTES:
        result['images'] = []
    return result


def _tests(scenario: ScenarioMark) -> list[dict[str, Any]]:
    return [
        {
            'name': mark.name,
            'description': scenario.name,
            'points': mark.points,
            'max_points': mark.max_points,
            'output': text[:_LONGEST_TEXT],
        }
        for mark, text in criteria_texts(scenario)
    ]


def _bundle(kit: Kit) -> Files:
    tests = {
        f'question/tests/{path}': content
        for path, content in kit.files.items()
        if path != kit.wheel
    }
    image = {f'image/{kit.wheel}': kit.files[kit.wheel]}
    return {**kit.filled_in('prairielearn'), **tests, **image}


PRAIRIELEARN = GradeFormat(
    'PrairieLearn: results.json; --make writes a question and its image',
    result_files('prairielearn', _result),
    _bundle,
)
