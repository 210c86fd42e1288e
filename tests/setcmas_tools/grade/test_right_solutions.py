"""Right solutions get all points, and keep away from the bounds."""

from functools import cache
from pathlib import Path

import pytest
import yaml

from setcmas_tools.grade.check import runs_here
from setcmas_tools.grade.criteria import Bounds
from setcmas_tools.grade.marking import mark
from setcmas_tools.grade.rubric import rubric_of_exercise
from setcmas_tools.submissions.submissions import Submission
from setcmas_tools.submissions.submitted_files import Student

SCRIPTS = Path(__file__).parents[2] / 'data' / 'exercises'
AWAY = 1 / 1.5
"""Largest share of an upper bound, and least share of a lower one, that a right solution needs."""

QUICK = {
    'consensus': ['gradient of the disagreement', 'the Laplacian'],
    'ctc': ['squares on both sides', 'with velocities'],
    'leader_follower_formation': ["leader's velocity from its positions", 'slower while it turns'],
    'nav_wp': ['while loop', 'slower while it turns'],
    'traj_tracking': ['numerical derivative, backward', 'saturates itself'],
    'coverage': [],  # each takes seconds
}
"""Solutions that are marked in the quick tests: those nearest to a bound, and with other laws."""

OTHERS = ['as in the text']


@cache
def solutions(exercise):
    listed = yaml.safe_load((SCRIPTS / exercise / 'right.yaml').read_text())
    return {one['name']: one['script'] for one in listed}


EXERCISES = sorted(path.parent.name for path in SCRIPTS.glob('*/right.yaml'))
ALL = [
    pytest.param(one, name, marks=() if name in QUICK.get(one, OTHERS) else pytest.mark.nightly)
    for one in EXERCISES
    for name in solutions(one)
]


rubric_of = cache(rubric_of_exercise)


def use(bounds: Bounds, number: float) -> float:
    """Return which share of a bound a number uses up."""
    upper = number / bounds.high
    return max(upper, bounds.low / number) if bounds.low > 0 else upper


@pytest.mark.parametrize(('exercise', 'name'), ALL)
def test_a_right_solution_gets_all_points_and_keeps_away_from_each_bound(exercise, name, tmp_path):
    (tmp_path / 'law.py').write_text(solutions(exercise)[name])
    rubric = rubric_of(exercise)

    run = runs_here(str(tmp_path / 'law.py'), rubric.function)
    marks = mark(rubric, run, Submission('law.py', Student('Ada')))

    assert marks.is_full
    assert (marks.score, marks.max_score) == (10, 10)
    by_scenario = zip(rubric.scenarios, marks.scenarios, strict=True)
    for scenario, found in by_scenario:
        assert not found.failure
        for criterion, one in zip(scenario.criteria, found.criteria, strict=True):
            assert use(criterion.bounds, one.reached) <= AWAY, (scenario.name, one.name)
