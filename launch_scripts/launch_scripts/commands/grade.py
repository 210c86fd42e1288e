"""Grade the submissions of a class by a rubric, each in a sandbox.

Writes a page per student, and tables for you and for learning platforms. Submissions cannot
interfere with how marks are computed. To resume an interrupted grading run, run the same
command in the same folder; it only regrades what has changed.

Examples:
  setcmas grade submissions --rubric consensus -o grades        a folder or a downloaded zip
  setcmas grade submissions.zip --rubric final.yaml
  setcmas grade --handout check.zip --rubric final.yaml     for students: without the solution
"""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from launch_scripts.terminal import warn
from setcmas_simu.errors import SetcmasError, file_errors, needs
from setcmas_simu.limited_file import write_together
from setcmas_simu.option_groups import Options, flag, option
from setcmas_simu.option_kinds import DURATION, Number, Whole

if TYPE_CHECKING:
    from setcmas_tools.grade.rubric import Rubric


RUBRIC = 'EXERCISE|FILE.yaml'
CORRECTIONS = 'corrections.yaml'


@dataclass(frozen=True, kw_only=True)
class GradeOptions(Options):
    """How submissions are graded."""

    TITLE: ClassVar[str] = 'grading'

    jobs: int | None = option(
        Whole(1), 'submissions graded at once', default=None, default_text='the number of cores'
    )
    trust: bool = flag(
        'run submissions without the sandbox: they can then do whatever you can; needed on '
        'systems where bubblewrap cannot confine them (macOS, Windows)'
    )
    call_timeout: float = option(
        Number(above=0, unit='s'), 'time limit of a call of the script', default=10.0
    )
    timeout: float = option(DURATION, 'time limit of a run', default=60.0)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    submissions = 'folder or zip file of the submissions'
    parser.add_argument('folder', metavar='FOLDER', nargs='?', type=Path, help=submissions)
    rubric = 'exercise or rubric file to grade by'
    parser.add_argument('--rubric', '-R', metavar=RUBRIC, required=True, help=rubric)
    folder = 'folder of the grades (default: grades)'
    parser.add_argument('--output', '-o', type=Path, metavar='DIR', help=folder)
    corrections = (
        'file with points set by hand and late penalties '
        f'(default: {CORRECTIONS} in DIR, if it is there)'
    )
    parser.add_argument('--corrections', type=Path, metavar='FILE', help=corrections)
    handout = 'only write the rubric for students, without the solution and the hidden parts'
    parser.add_argument('--handout', type=Path, metavar='FILE.zip', help=handout)
    GradeOptions.add_to(parser)


def main(args: argparse.Namespace) -> int:
    """Grade a class, or write the rubric for students; return the exit status."""
    from setcmas_tools.grade.rubric import chosen_rubric  # late: help needs no numpy

    options = GradeOptions.of(args)
    rubric = chosen_rubric(None, args.rubric)
    if args.handout:
        from setcmas_tools.grade.rubric_handout import archive, handout

        top = f'{rubric.file.stem}_check'
        content = archive({f'{top}/{path}': one for path, one in handout(rubric).items()})
        with file_errors(f"'{args.handout}' cannot be written"):
            args.handout.write_bytes(content)
        print(f'for students: {args.handout}')
        return 0
    if not args.folder:
        raise SetcmasError('FOLDER is missing; name the folder of the submissions')
    folder = args.output or Path('grades')
    if args.folder.resolve() in (folder.resolve(), *folder.resolve().parents):
        place = f"in the folder of the submissions, '{args.folder}'"
        raise SetcmasError(f"grades '{folder}' would be {place}; choose another folder with -o")
    try:
        with file_errors(f"'{folder}' cannot be written"):
            return _grade(args, rubric, options, folder)
    except KeyboardInterrupt:
        warn('setcmas grade: stopped; run the same command to continue')
        raise


def _grade(args: argparse.Namespace, rubric: Rubric, options: GradeOptions, folder: Path) -> int:
    with needs('grade'):  # before the class is graded, not when its pages are written
        import jinja2  # noqa: F401

    from setcmas_tools.grade.class_grading import NOT_RUN, Grader, grade, read_class
    from setcmas_tools.grade.corrections import corrected, read_corrections
    from setcmas_tools.grade.gradebook import marks_table, pages_of, tables_of
    from setcmas_tools.grade.submission_run import Times

    submissions = read_class(args.folder, rubric, not options.trust)
    students = [(one.name, one.student) for one in submissions]
    if not args.corrections and (misplaced := args.folder / CORRECTIONS).is_file():
        raise SetcmasError(f"move '{misplaced}' to '{folder}', or name it with --corrections")
    file = args.corrections or folder / CORRECTIONS
    is_used = args.corrections or file.is_file()
    changes = read_corrections(file, students, rubric) if is_used else []
    grader = Grader(rubric, Times(options.call_timeout, options.timeout), not options.trust)
    graded = grade(submissions, grader, folder, options.jobs)
    marks = [corrected(one, changes) for one in graded]
    tables = tables_of(marks)
    _write(folder, tables, pages_of(marks))
    print(marks_table(marks))  # after the files: the reader of the output may be gone
    print(f'{_count(marks)}: {", ".join(tables)} and a page for each student in {folder}')
    if undecided := [one for one in marks if not one.is_decided]:
        print(
            f'{_count(undecided)} without a grade: the remarks say why; have it handed in again, '
            f'or decide in {CORRECTIONS}'
        )
    return 1 if any(one.failure and one.failure.message == NOT_RUN for one in undecided) else 0


def _count(submissions: Sequence[object]) -> str:
    return f'{len(submissions)} submission{"" if len(submissions) == 1 else "s"}'


def _write(folder: Path, tables: Mapping[str, str], pages: Mapping[str, str]) -> None:
    """Write tables and pages by path, all or nothing; a table that changes stays as NAME.bak."""
    for name, text in tables.items():
        table = folder / name
        if table.is_file() and table.read_bytes() != text.encode(errors='replace'):
            shutil.copyfile(table, folder / f'{name}.bak')
    write_together({folder / path: text for path, text in {**tables, **pages}.items()})
    for page in (folder / 'students').glob('*.html'):
        if page.relative_to(folder).as_posix() not in pages:  # its student has left
            page.unlink()
