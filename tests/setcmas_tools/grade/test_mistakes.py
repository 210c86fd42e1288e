"""Mistakes of students: each loses points, and its hint is true."""

import re
from pathlib import Path

import pytest
import yaml
from sandboxes import needs_sandbox

from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade.check import marks_of as own_marks
from setcmas_tools.grade.check import runs_here
from setcmas_tools.grade.class_grading import Grader
from setcmas_tools.grade.marking import unmarked
from setcmas_tools.grade.rubric import rubric_of_exercise
from setcmas_tools.submissions.submissions import Submission
from setcmas_tools.submissions.submitted_files import Student

pytestmark = needs_sandbox

EXERCISES = Path(__file__).parents[2] / 'data' / 'exercises'
NAMES = sorted(path.parent.name for path in EXERCISES.glob('*/mistakes.yaml'))
POINTS = yaml.safe_load((EXERCISES / 'points.yaml').read_text())
MOST_UNEXPLAINED = 0  # of each exercise: their hint is where the run first differs


def mistakes_of(name):
    """Return the mistakes in an exercise, each with its script."""
    content = yaml.safe_load((EXERCISES / name / 'mistakes.yaml').read_text())
    found = []
    for one in content['mistakes']:
        script = one.get('script') or content['solution']
        for old, new in one.get('change', {}).items():
            assert old in script, one['name']
            script = script.replace(old, new)
        found.append({**one, 'script': script})
    return found


def marks_of(name, mistakes, folder):
    """Return the marks by name, as `check` computes them, or `grade` for scripts that hang."""
    rubric = rubric_of_exercise(name).shown()
    run, found = runs_here(str(folder / 'law.py'), rubric.function), {}
    for one in mistakes:
        own = Submission('law', Student('Ada'), 'law.py', {'law.py': one['script'].encode()})
        (folder / 'law.py').write_text(one['script'])
        try:
            found[one['name']] = (
                Grader(rubric).marks(own)
                if one.get('slow')
                else own_marks(folder / 'law.py', rubric, run)
            )
        except SetcmasError as error:
            found[one['name']] = unmarked(rubric, own, str(error))
    return found


def messages(marks):
    """Return the hints, and the messages of failures."""
    failures = [marks.failure, *(one.failure for one in marks.scenarios)]
    hints = [one.hint for scenario in marks.scenarios for one in scenario.criteria if one.hint]
    shown = [hint for hint in hints if not hint.startswith('This counts only with')]
    return shown, [one.message for one in failures if one]


def complaints(mistake, marks):
    """Yield what is wrong with the marks of a mistake."""
    hints, failures = messages(marks)
    text = ' '.join([*hints, *failures])
    if marks.is_full is not mistake.get('harmless', False):
        yield f'it gets {marks.points_text}'
    is_explained = bool(hints or failures or marks.unfilled or marks.is_full)
    if len(hints) > 1 or not is_explained:
        yield f'not one explanation: {hints} {failures}'
    unclear = is_unexplained(marks) or marks.unfilled or marks.is_full
    wanted = [] if unclear else mistake.get('must', [])
    if wanted and not any(has(text, words) for words in wanted):
        yield f'none of {wanted} in: {text}'
    yield from (
        f'{words!r} in: {text}' for words in mistake.get('must_not', []) if has(text, words)
    )


def has(text, words):
    return re.search(str(words), text, re.IGNORECASE)


def is_unexplained(marks):
    return any(' first differs from the solution ' in hint for hint in messages(marks)[0])


def unfair(name, marks):
    """Return the mistakes that get other points than a lecturer would give, and those points."""
    wanted = POINTS.get(name, POINTS['of any law'])
    scores = {mistake: marks[mistake].score for mistake in wanted if mistake in marks}
    too_little = POINTS['too little'].get(name, [])
    return {
        mistake: (score, least, most)
        for mistake, score in scores.items()
        for least, most in [wanted[mistake]]
        if not least <= score <= most and not (mistake in too_little and score < least)
    }


@pytest.mark.parametrize(
    ('name', 'count'),
    [('consensus', 1), *(pytest.param(name, None, marks=pytest.mark.nightly) for name in NAMES)],
)
def test_mistakes_of_an_exercise_lose_points_and_are_explained(tmp_path, name, count):
    mistakes = mistakes_of(name)
    assert len(mistakes) >= 12
    assert POINTS.get(name, {}).keys() <= {one['name'] for one in mistakes}
    marks = marks_of(name, mistakes[:count], tmp_path)

    complained = [
        f'{one["name"]}: {complaint}'
        for one in mistakes[:count]
        for complaint in complaints(one, marks[one['name']])
    ]
    assert complained == []
    assert unfair(name, marks) == {}
    unexplained = [
        one['name']
        for one in mistakes[:count]
        if one.get('must') and is_unexplained(marks[one['name']])
    ]
    assert len(unexplained) <= MOST_UNEXPLAINED
