"""The format `gradescope`: results.json of an autograder, and the autograder itself.

Fields as in gradescope-autograders.readthedocs.io, specs.
"""

from __future__ import annotations

from typing import Any

from setcmas_tools.grade.marks import Marks
from setcmas_tools.platforms.autograder import Kit
from setcmas_tools.platforms.grade_format import (
    Files,
    GradeFormat,
    criteria_texts,
    marked_file,
    result_files,
    summary,
)


def _result(marks: Marks) -> dict[str, Any]:
    return {
        'score': marks.score,
        'output': '\n'.join(filter(None, (marked_file(marks), summary(marks)))),
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
