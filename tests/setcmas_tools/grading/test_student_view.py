from graded_classes import graded_class

from setcmas_tools.grading.student_view import student_view


def test_hidden_points_count_and_nothing_else_of_them_is_left():
    for marks in graded_class():
        shown = student_view(marks)

        assert shown.score == marks.score
        assert shown.max_score == marks.max_score
        assert 'SECRET' not in repr(shown)
        assert shown.similar == ()
