import pytest

from setcmas_tools.grading.submissions.identity import identity_of


@pytest.mark.parametrize(
    ('name', 'student', 'number', 'file'),
    [
        ('Ada King Lovelace_12345_assignsubmission_file_', 'Ada King Lovelace', '12345', ''),
        ('Ada_Lovelace_12345_assignsubmission_file_law.py', 'Ada_Lovelace', '12345', 'law.py'),
        ('lovelaceada_123_4567_law.py', 'lovelaceada', '123', 'law.py'),
        ('lovelaceada_LATE_123_4567_my_law-2.py', 'lovelaceada', '123', 'my_law.py'),
        ('ada_lovelace.py', 'ada lovelace', '', ''),
        ('ada@example.org.py', 'ada@example.org', 'ada@example.org', ''),
        ('consensus_2_final.py', 'consensus 2 final', '', ''),
    ],
)
def test_a_name_tells_whose_a_submission_is(name, student, number, file):
    identity = identity_of(name, name.removesuffix('.py'))

    assert (identity.student.name, identity.student.id) == (student, number)
    assert identity.file == file
