"""The check of a function of a notebook."""

import numpy as np
import pytest

from setcmas_ctrl.laws.script_loader import EXERCISES
from setcmas_simu.errors import SetcmasError
from setcmas_tools import check


def control(robotNo, nbRobots, poses, t):
    p = poses[:2, robotNo - 1]
    angle = 0.2 * t
    r = 2 * np.array([np.cos(angle), np.sin(angle)])
    return tuple(0.8 * (r - p))


def test_a_function_is_checked_and_shown_in_a_notebook():
    result = check(control, 'traj_tracking')
    page = result._repr_html_()
    assert result.marks.score == 5.09
    assert '✓ 4/4  it follows the point: tracking_error 0.5 m' in str(result)
    assert 'answer_error 111 % (wanted: at most 8 %)' in str(result)
    assert '\nanswer_error: relative difference between' in str(result)
    assert 'Your velocity is KP (r - p) alone' in str(result)
    assert 'src="data:image/png;base64,' in page
    assert '&lt;' not in page
    assert '<pre' in page
    assert repr(result) == str(result)  # in IPython, outside of notebooks
    assert repr(result.marks) == 'Marks(Trajectory tracking, control, 5.09 of 10 points)'
    assert len(repr(result.marks.scenarios[0])) < 3000


RUBRIC = """
title: Meet
scenarios: [{name: two, nb_robots: 2, duration: 1, criteria: [
  {name: they meet, metric: disagreement, at_most: 9, points: 1}]}]
"""


def test_a_check_without_paths_has_no_picture(tmp_path):
    (tmp_path / 'meet.yaml').write_text(RUBRIC)
    (tmp_path / 'law.py').write_text('x = =\n')
    page = check(tmp_path / 'law.py', tmp_path / 'meet.yaml')._repr_html_()

    assert 'SyntaxError' in page
    assert '<img' not in page


def test_a_function_cannot_say_which_exercise_it_is():
    with pytest.raises(SetcmasError, match='a function names no exercise'):
        check(control)


def test_a_law_that_calls_check_is_refused_with_its_line(tmp_path):
    law = tmp_path / 'law.py'
    law.write_text(
        'from setcmas_tools import check\n'
        'def control(robotNo, nbRobots, poses, t):\n    return 0, 0\n'
        "check(__file__, 'nav_wp')\n"
    )

    text = str(check(law, 'nav_wp'))

    assert 'law.py, line 4: RuntimeError: a law that is being marked cannot call check()' in text
    assert "put this line below `if __name__ == '__main__':`" in text


@pytest.mark.parametrize('name', ['consensus', 'ctc', 'point_ahead'])
def test_an_untouched_exercise_gets_no_points(name, tmp_path):
    script = tmp_path / f'my_{name}.py'
    script.write_text(EXERCISES.file(name).read_text().replace('# TODO', '# I do not know'))

    marks = check(script, name).marks

    assert marks.unfilled
    assert (marks.score, marks.max_score) == (0, 10)
