"""Rubrics in files of one's own: what they may say, and the lines of their mistakes."""

from dataclasses import replace

import pytest

from setcmas_ctrl.laws.script_loader import ALGORITHMS
from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade.criteria import Criterion
from setcmas_tools.grade.rubric import read_rubric, rubric_of_exercise

RUBRIC = """\
title: Meeting
solution: mine.py
scenarios:
  - name: some
    nb_robots: 3
    duration: 5
    poses: {2: [1, 2]}
    graph: links.yaml
    loss: 1e-1
    criteria:
      - {metric: disagreement, at_most: 0.1, none_at: 1, points: 2, hint: Go on.}
      - {name: near, metric: path_error, at_most: 0.2, needs: disagreement at most 0.1 m}
"""


@pytest.fixture
def read(tmp_path):
    """A function that reads a rubric of some text, with a part of it replaced."""

    def read(old='', new='', text=RUBRIC):
        assert old in text
        (tmp_path / 'mine.py').write_bytes(ALGORITHMS.file('consensus').read_bytes())
        (tmp_path / 'links.yaml').write_text('edges: [1 - 2, 2 - 3]\n')
        file = tmp_path / 'rubric.yaml'
        file.write_text(text.replace(old, new, 1) if old else text)
        return read_rubric(file)

    return read


def test_a_rubric_says_what_is_run_and_what_it_is_worth(read, tmp_path, monkeypatch):
    monkeypatch.chdir('/')
    rubric = read()
    [scenario] = rubric.scenarios
    first, second = scenario.criteria
    assert (rubric.title, rubric.max_score) == ('Meeting', 3)
    assert rubric.solution == tmp_path / 'mine.py'
    assert {file.name for file in rubric.files} == {'rubric.yaml', 'mine.py', 'links.yaml'}
    assert scenario.base.communication.loss == 0.1
    assert scenario.base.robots.poses == {2: (1, 2, 0)}
    assert (first.wanted, second.needs) == ('at most 0.1 m', first.name)
    assert len(rubric.solution_run(scenario).robots) == 3


def test_modules_that_a_solution_imports_belong_to_its_rubric(read, tmp_path):
    rubric = read()
    (tmp_path / 'mine.py').write_text('import gains\n')
    (tmp_path / 'gains.py').write_text('from more import gain\n')
    (tmp_path / 'more').mkdir()
    (tmp_path / 'more' / '__init__.py').write_text('gain = 1\n')

    assert {tmp_path / 'gains.py', tmp_path / 'more' / '__init__.py'} <= {*rubric.files}


@pytest.mark.parametrize(
    ('old', 'new', 'line', 'words'),
    [
        ('title:', 'titel:', 1, 'did you mean title'),
        ('mine.py', 'yours.py', 2, "no file 'yours.py'"),
        ('2: [', '5: [', 7, 'the fleet has robots 1 to 3'),
        ('loss: 1e-1', 'compared_robots: [4]', 9, 'a whole number from 1 to 3'),
        ('disagreement', 'disagrement', 11, "metric is 'disagrement'; did you mean disagreement?"),
        ('at_most: 0.1, ', '', 11, 'one of at_most, at_least'),
        ('none_at: 1', 'none_at: 0.1', 11, 'it must be above 0.1'),
        ('at_most: 0.1, ', 'at_most: 1, at_least: 0, ', 11, 'two bounds, at_most and at_least'),
        ('metric: path_error', 'metric: filter_overruled_s', 4, 'add filter: barrier'),
        ('at_most: 0.2', 'between: [2, 1]', 12, 'the smaller one first'),
        ('needs: dis', 'needs: ', 12, "an earlier criterion: 'disagreement at most 0.1 m'"),
        ('points: 2', 'points: 3.333', 11, 'a number with at most two decimals'),
        ('solution: mine.py\n', '', 3, 'add solution: FILE'),
    ],
)
def test_a_mistake_is_reported_with_its_line(read, old, new, line, words):
    with pytest.raises(SetcmasError) as error:
        read(old, new)
    assert f'rubric.yaml, line {line}: ' in str(error.value)
    assert words in str(error.value)
    assert '\n' not in str(error.value)


def test_names_of_laws_mean_those_that_ship(read, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'consensus.py').write_text('mine = True')
    assert read('mine.py', 'consensus').solution == ALGORITHMS.file('consensus')


def test_a_metric_that_the_solution_has_not_is_the_teachers_to_mend(read):
    rubric = read()
    [scenario] = rubric.scenarios
    misspelt = replace(scenario, criteria=(Criterion('', 'excursion_s', 1),))
    with pytest.raises(SetcmasError, match="excursion_s, in scenario 'some' of "):
        rubric.solution_run(misspelt)


def test_students_do_not_see_what_the_solution_prints(capfd):
    rubric = rubric_of_exercise('bearing_formation')
    ring = rubric.scenarios[-1]  # the solution warns that its graph is not rigid

    assert rubric.solution_run(ring)

    assert capfd.readouterr() == ('', '')
