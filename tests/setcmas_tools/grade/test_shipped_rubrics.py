"""The rubrics that ship: an empty exercise gets nothing, a class what a lecturer would give."""

import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from sandboxes import needs_sandbox

from setcmas_ctrl.laws.script_loader import EXERCISES
from setcmas_tools.grade import class_grading
from setcmas_tools.grade.check import OwnLaw, runs_here
from setcmas_tools.grade.rubric import rubric_of_exercise
from setcmas_tools.grade.submission_run import Times

DATA = Path(__file__).parents[2] / 'data' / 'class_of_thirty.yaml'
EXERCISE_NAMES = ['consensus', 'ctc', 'leader_follower_formation', 'nav_wp', 'traj_tracking']


@pytest.mark.parametrize('name', EXERCISE_NAMES)
def test_an_untouched_exercise_gets_no_points(name, tmp_path):
    script = tmp_path / f'my_{name}.py'
    script.write_text(EXERCISES.file(name).read_text().replace('# TODO', '# I do not know'))
    rubric = rubric_of_exercise(name)

    untouched = OwnLaw.of(script).marks(rubric, runs_here(str(script)))

    assert untouched.unfilled
    assert (untouched.score, untouched.max_score) == (0, 10)


def handed_in(entries, folder):
    """Write the submissions as Moodle does, a folder for each student."""
    for entry in entries:
        place = folder / entry['student']
        place.mkdir(parents=True)
        if 'zip' in entry:
            with zipfile.ZipFile(place / entry['zip'], 'w') as archive:
                for name, content in entry['files'].items():
                    archive.writestr(name, content)
        else:
            for name, content in entry['files'].items():
                (place / name).write_text(content)
    return folder


@needs_sandbox
@pytest.mark.nightly
def test_a_class_gets_the_points_that_a_lecturer_would_give(tmp_path):
    entries = {entry['student'].split('_')[0]: entry for entry in yaml.safe_load(DATA.read_text())}
    assert len(entries) == 30
    place = handed_in(entries.values(), tmp_path / 'class')
    rubric = replace(rubric_of_exercise('consensus'), mistakes=())  # points do without hints
    grader = class_grading.Grader(rubric, Times(call=2.0))

    submissions = class_grading.read_class(place, rubric, 2, is_confined=True)
    marks = class_grading.grade(submissions, grader, tmp_path / 'grades')

    scores = {one.student.name: one.score for one in marks}
    assert scores.keys() == entries.keys()
    unfair = {
        name: (scores[name], entry['points'], entry['why'])
        for name, entry in entries.items()
        if not entry['points'][0] <= scores[name] <= entry['points'][1]
    }
    assert unfair == {}
