from graded_classes import marks_of

from setcmas_tools.grading.pages.file_names import file_names


def test_names_are_safe_and_unique_on_systems_that_ignore_case():
    students = ['Ada', 'ada', '../../etc/passwd', '<>|', 'x' * 300, 'Bülent Çelik', 'con*']
    names = file_names([marks_of(one, 1.0, id='7' * (one == 'con*')) for one in students])

    assert names == ['Ada', 'ada_2', 'etc_passwd', 'student', 'x' * 80, 'Bulent_Celik', 'con_7']
