import pytest

from setcmas_ctrl.laws.exercise import exercise_of, is_unfilled, unfilled_note
from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES


@pytest.fixture
def copy(tmp_path):
    """A function that writes a copy of the consensus exercise with a part of it replaced."""

    def copy(old='', new=''):
        text = EXERCISES.file('consensus').read_text()
        assert old in text
        path = tmp_path / 'mine.py'
        path.write_text(text.replace(old, new))
        return path

    return copy


@pytest.mark.parametrize(
    ('old', 'new', 'unfilled'),
    [
        ('', '', True),
        ('# TODO: add', '# What is to be added?', True),
        ('K = 0.5', 'K = 0.7', True),
        ('pass', 'v += 1', False),
        ('pass', 'v +=', False),  # reported where it is loaded
    ],
)
def test_a_copy_is_not_filled_in_until_its_maths_changes(copy, old, new, unfilled):
    script = copy(old, new)
    assert is_unfilled(script) == unfilled
    assert ('mine.py is not filled in yet' in unfilled_note(script)) == unfilled


def test_a_script_declares_its_exercise_or_has_its_name(copy, tmp_path):
    assert exercise_of(copy()) == 'consensus'
    assert exercise_of(copy("exercise = 'consensus'", '')) == ''
    assert exercise_of(ALGORITHMS.file('nav_wp')) == 'nav_wp'
    assert not is_unfilled(ALGORITHMS.file('nav_wp'))
    assert unfilled_note(EXERCISES.file('nav_wp')).startswith('exercise nav_wp is not filled in')
