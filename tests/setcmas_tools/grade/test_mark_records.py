"""What students see of their marks."""

from dataclasses import asdict

from graded_classes import graded_class

from setcmas_tools.grade.mark_records import student_view


def test_hidden_points_count_and_nothing_else_of_them_is_left():
    for marks in graded_class():
        shown = student_view(marks)

        assert shown.score == marks.score
        assert shown.max_score == marks.max_score
        assert 'SECRET' not in str(asdict(shown))
        assert shown.similar == ()
