"""Corrections of an assistant, as they are typed into corrections.yaml."""

from dataclasses import replace
from unicodedata import normalize

import pytest
from graded_classes import marks_of

from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade import corrections
from setcmas_tools.grade.gradebook import pages_of, tables_of
from setcmas_tools.grade.mark_records import Failure
from setcmas_tools.grade.rubric import read_rubric

RUBRIC = """
scenarios:
  - name: Five robots
    nb_robots: 5
    criteria:
      - {name: All meet, metric: disagreement, at_most: 0.05, points: 4}
      - {name: They settle, metric: settling_time, at_most: 20, points: 2}
      - {name: SECRET bound, metric: path_length, at_most: 12, points: 1.5, hidden: true}
  - name: SECRET ring
    hidden: true
    criteria:
      - {name: SECRET, metric: path_length, at_most: 12}
"""
CLASS = [
    marks_of('Zoé Lovelace', 4.0, id='12345', submission='Zoe Lovelace_12345_file_'),
    marks_of('Alan Turing', 1.0, id='777', email='alan@example.org'),
]
SIGNED = 'author: Ann\ndate: 2026-11-22\n'


@pytest.fixture
def corrected(tmp_path):
    """A function that applies the text of a file of corrections to the class."""

    def read(text, marks=CLASS):
        (tmp_path / 'rubric.yaml').write_text(RUBRIC)
        (tmp_path / 'corrections.yaml').write_text(text)
        students = [(one.submission, one.student) for one in marks]
        rubric = read_rubric(tmp_path / 'rubric.yaml')
        changes = corrections.read_corrections(tmp_path / 'corrections.yaml', students, rubric)
        return [corrections.corrected(one, changes) for one in marks]

    return read


def one_of(correction):
    return f'{SIGNED}corrections:\n  - {{{correction}, reason: seen by hand}}\n'


@pytest.mark.parametrize(
    ('correction', 'score'),
    [
        ('student: Zoé Lovelace, criterion: They settle, points: 2', 7.5),
        ('student: 12345, criterion: "Five robots: They settle", points: 1.5', 7.0),
        (f'student: {normalize("NFD", "zoé  lovelace")}, add: 0.5', 6.0),
        ('student: Zoe Lovelace_12345_file_, add: -9', 0.0),
        ('student: 12345, total: 8', 8.0),
    ],
)
def test_a_person_changes_points_and_the_automatic_mark_is_kept(corrected, correction, score):
    zoe, alan = corrected(one_of(correction))

    assert (zoe.score, zoe.automatic) == (score, 5.5)
    assert (alan.score, alan.corrections) == (2.5, ())
    assert (zoe.corrections[0].author, zoe.corrections[0].date) == ('Ann', '2026-11-22')


LATE = f"""{SIGNED}late:
  per_day: 1
  at_most: 2.25
  days: {{alan@example.org: 2, 12345: 0}}
"""


@pytest.mark.parametrize(('days', 'score'), [(0, 2.5), (1, 1.5), (2, 0.5), (9, 0.25)])
def test_days_late_cost_points(corrected, days, score):
    zoe, alan = corrected(LATE.replace('org: 2', f'org: {days}'))

    assert (zoe.score, zoe.corrections) == (5.5, ())
    assert alan.score == score
    assert [one.what.split()[0] for one in alan.corrections] == [str(days)] * bool(days)


def test_lateness_costs_nothing_where_there_is_no_grade_yet(corrected):
    alan = replace(CLASS[1], failure=Failure('two scripts'))
    late = LATE.replace(', 12345: 0', '')

    assert not corrected(late, [alan])[0].is_decided
    [marks] = corrected(f'{late}{one_of("student: 777, total: 4").removeprefix(SIGNED)}', [alan])
    assert (marks.is_decided, marks.score) == (True, 4.0)


@pytest.mark.parametrize(
    ('text', 'line', 'message'),
    [
        (one_of('student: Zoé Lovelance, add: 1'), 4, 'did you mean Zoé Lovelace?'),
        (
            one_of('student: 777, criterion: They setle, points: 1'),
            4,
            "no criterion 'They setle'; did you mean They settle?",
        ),
        (one_of('student: 777, criterion: All meet, points: 5'), 4, 'from 0 to 4'),
        (one_of('student: 777, points: 5'), 4, 'add criterion: NAME, or use add or total'),
        (one_of('student: 777, add: 1, total: 3'), 4, 'exactly one of points, add and total'),
        (one_of('student: 777, add: 1').replace('2026-11-22', 'yesterday'), 2, 'a date such as'),
        (one_of('student: 777, add: 1').replace('author: Ann\n', ''), 1, 'author is missing'),
        (LATE.replace('12345', 'Bob'), 6, "no student 'Bob'"),
        (LATE.replace('per_day: 1', ''), 3, 'late has no per_day'),
        (LATE.replace('1\n', 'ten\n'), 4, "late.per_day is 'ten'; it must be a number"),
        (LATE.replace('org: 2', 'org: 2026-11-20'), 6, 'a whole number'),
        (one_of('student: 777, criterion: All meet, add: 1'), 4, 'add belongs to no criterion'),
        ('curve: {scale: 1.1}', 1, "there is no key 'curve'"),
    ],
)
def test_a_mistake_is_one_line_with_its_file_and_line(corrected, text, line, message):
    with pytest.raises(SetcmasError) as error:
        corrected(text)

    assert f'corrections.yaml, line {line}: ' in str(error.value)
    assert message in str(error.value)
    assert '\n' not in str(error.value)


def test_corrections_are_on_pages_and_in_every_export_beside_the_automatic_mark(corrected):
    hidden = 'student: 12345, criterion: SECRET bound, points: 1.5'
    marks = corrected(
        one_of(hidden) + one_of('student: 777, add: 1').partition('corrections:\n')[2]
    )
    texts = tables_of(marks)
    del texts['canvas.csv']  # which has grades only
    texts['pages'] = ''.join(pages_of(marks).values())

    for name, text in texts.items():
        assert 'seen by hand' in text, name
        assert 'Ann' in text, name
        assert 'SECRET' not in text or name == 'grades.csv'
        assert '2.5' in text, name  # Alan's automatic mark
