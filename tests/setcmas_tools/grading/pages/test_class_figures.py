from graded_classes import graded_class

from setcmas_tools.grading.pages.class_figures import (
    Likeness,
    bins,
    hardest_first,
    has_failed,
    likeness_pairs,
)


def test_figures_of_a_class():
    marks = graded_class()

    assert bins(marks) == [0, 1, 1, 0, 0, 0, 2, 0, 0, 0]
    assert [one.name for one in hardest_first(marks)] == [
        'They settle', 'SECRET bound', 'All meet', 'SECRET',
    ]  # fmt: skip
    assert [has_failed(one) for one in marks] == [False, False, True, False]


def test_a_pair_that_tells_of_each_other_is_one_likeness():
    from dataclasses import replace

    from setcmas_tools.grading.marks import Similar

    one, other, *_ = graded_class()
    pair = [
        replace(one, similar=(Similar(other.submission, 0.9),)),
        replace(other, similar=(Similar(one.submission, 0.9),)),
    ]

    [found] = likeness_pairs(pair)
    assert found == Likeness(other.submission, one.submission, 0.9)
