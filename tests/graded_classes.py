"""Marks of a class as graders make them, with hostile names, for tests of pages and formats."""

from setcmas_tools.grade.mark_records import CriterionMark, Failure, Marks, RobotPath, ScenarioMark
from setcmas_tools.submissions.likeness import Similar
from setcmas_tools.submissions.submitted_files import Student

HOSTILE = '<script>document.title="forged"</script>'
PATHS = (
    RobotPath(1, ((5, 5), (3, 3.4), (1, 1.2), (0.1, 0.2)), ((5, 5), (2.4, 2.4), (0, 0))),
    RobotPath(2, ((-5, 4), (-3, 1), (0.2, 0.1)), ((-5, 4), (-2.4, 2), (0, 0))),
    RobotPath(7, ((1e9, 2), (2, -4)), ((2, -4), (1, -2), (0, 0))),
)


def marks_of(name, points, **known):
    """Return marks with two shown criteria, a hidden one, and a hidden scenario."""
    settle = CriterionMark(
        'All meet', points, 4.0, 'disagreement', '≤ 0.05 m', 0.031, 'm',
        '' if points == 4 else 'Each robot should go towards the mean of all poses.',
    )  # fmt: skip
    never = CriterionMark('They settle', 0.0, 2.0, 'settling', '< 20 s', None, 's', f'{HOSTILE}?')
    secret = CriterionMark(
        'SECRET bound', 0.5, 1.5, 'effort', '≤ 12', 20.0, '', 'SECRET hint', hidden=True
    )
    hidden = ScenarioMark('SECRET ring', (CriterionMark('SECRET', 1.0, 1.0, 'x', '', 0.0),))
    first = ScenarioMark('Five robots', (settle, never, secret), known.pop('failed', None), PATHS)
    hidden = ScenarioMark(hidden.name, hidden.criteria, hidden=True)
    student = Student(name, known.pop('id', ''), known.pop('email', ''))
    submission = known.pop('submission', f'{name}.py')
    return Marks(submission, student, 'Consensus: the lab', (first, hidden), **known)


def graded_class():
    """Return the marks of four submissions: a good one, a hostile one, one that fails, a copy."""
    message = f'ValueError: {HOSTILE}: too many values to unpack (law.py, line 2)'
    failed = Failure(f'{message}\n  2 | x, y = poses[:, robotNo]', robot=3, t=0.4)
    return [
        marks_of('Ada Lovelace', 4.0, id='12345', submission='Lovelace Ada_12345_file_/law.py'),
        marks_of(HOSTILE, 1.0, id='=1+2', similar=(Similar('Ada Lovelace.py', 0.97),)),
        marks_of('Çelik, "Bülent"', 0.0, failed=failed, email='b@example.org'),
        marks_of('Ünsal\x1b[2J\x00', 4.0, similar=(Similar('the built-in law consensus', 1.0),)),
    ]
