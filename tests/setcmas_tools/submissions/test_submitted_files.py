import pytest

from setcmas_tools.submissions.submitted_files import identity_of


@pytest.mark.parametrize(
    ('name', 'student', 'number', 'file'),
    [
        ('Ada King Lovelace_12345_assignsubmission_file_', 'Ada King Lovelace', '12345', ''),
        ('Ada_Lovelace_12345_assignsubmission_file_law.py', 'Ada_Lovelace', '12345', 'law.py'),
        ('lovelaceada_123_4567_law.py', 'lovelaceada', '123', 'law.py'),
        ('lovelaceada_LATE_123_4567_my_law-2.py', 'lovelaceada', '123', 'my_law-2.py'),
        ('anon_h7KqZ_LATE_9005_law.py', 'anon_h7KqZ', '', 'law.py'),
        ('lovelaceada_LATE_123_text.html', 'lovelaceada', '123', ''),
        ('ada_lovelace.py', 'ada lovelace', '', ''),
        ('J. Smith', 'J. Smith', '', ''),
        ('ada@example.org.py', 'ada@example.org', 'ada@example.org', ''),
        ('consensus_2_final.py', 'consensus 2 final', '', ''),
    ],
)
def test_a_file_name_gives_the_student(name, student, number, file):
    identity = identity_of(name)

    assert (identity.student.name, identity.student.id) == (student, number)
    assert identity.file == file


def test_two_students_with_one_number_are_two_submissions_and_two_folders_of_one_are_one():
    names = ['Ada_1_assignsubmission_file_', 'Ada_1_assignsubmission_onlinetext_']
    groups = [identity_of(name).group for name in (*names, 'Bob_1_assignsubmission_file_')]

    assert groups[0] == groups[1] != groups[2]
