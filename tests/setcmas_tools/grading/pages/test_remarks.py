from graded_classes import graded_class

from setcmas_tools.grading.pages.remarks import marks_table


def test_names_with_control_characters_do_not_reach_the_terminal():
    table = marks_table(graded_class())

    assert 'points of 8.5' in table
    assert all(each.isprintable() or each == '\n' for each in table)
    assert len(table.splitlines()) == 6
