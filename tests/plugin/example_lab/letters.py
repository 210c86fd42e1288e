"""The grade format `letters`: a letter per student."""

from setcmas_tools.platforms.grade_format import GradeFormat

LETTERS = 'FFFFFEDCBA'  # by tenths of the points


def write_letters(marks):
    """Return the file of the format, with a line per submission."""
    lines = []
    for one in marks:
        tenth = min(int(10 * one.score / one.max_score), 9)
        lines.append(f'{one.student.name}: {LETTERS[tenth]}\n')
    return {'letters.txt': ''.join(lines)}


FORMAT = GradeFormat('Letters from A to F', write_letters)
