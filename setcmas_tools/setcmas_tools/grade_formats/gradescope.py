"""The format `gradescope`: results.json of an autograder, and the autograder itself.

Fields as in gradescope-autograders.readthedocs.io, specs.
"""

from __future__ import annotations

from typing import Any

from setcmas_tools.grade_formats.bundles.kit import Kit
from setcmas_tools.grade_formats.feedback import criteria_texts, summary
from setcmas_tools.grade_formats.format import Files, GradeFormat, result_files
from setcmas_tools.grading.marks import Marks


def _result(marks: Marks) -> dict[str, Any]:
    return {
        'score': marks.score,
        'output': summary(marks),
        'stdout_visibility': 'hidden',
        'tests': [
            {
                'number': f'{major}.{minor}',
                'name': f'{scenario.name}: {mark.name}',
                'score': mark.points,
                'max_score': mark.max_points,
                'output': text,
                'visibility': 'visible',
            }
            for major, scenario in enumerate(marks.scenarios, start=1)
            for minor, (mark, text) in enumerate(criteria_texts(scenario), start=1)
        ],
    }


def _bundle(kit: Kit) -> Files:
    return {**kit.filled_in('gradescope'), **kit.files}


GRADESCOPE = GradeFormat(
    'Gradescope: results.json; --make writes autograder.zip',
    result_files('gradescope', _result),
    _bundle,
)
