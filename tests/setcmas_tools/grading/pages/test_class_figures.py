import pytest
from graded_classes import graded_class

from setcmas_tools.grading.pages.class_figures import Likeness, class_figures


def test_figures_of_a_class():
    figures = class_figures(graded_class())

    assert figures.mean == pytest.approx(3.75)
    assert figures.median == 4.0
    assert figures.bins == (0, 1, 1, 0, 0, 0, 2, 0, 0, 0)
    assert [one.name for one in figures.criteria] == [
        'They settle', 'SECRET bound', 'All meet', 'SECRET',
    ]  # fmt: skip
    assert figures.failed == 1


def test_a_pair_that_tells_of_each_other_is_one_likeness():
    from dataclasses import replace

    from setcmas_tools.grading.marks import Similar

    one, other, *_ = graded_class()
    pair = [
        replace(one, similar=(Similar(other.submission, 0.9),)),
        replace(other, similar=(Similar(one.submission, 0.9),)),
    ]

    [found] = class_figures(pair).likenesses
    assert found == Likeness(other.submission, one.submission, 0.9)
