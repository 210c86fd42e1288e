"""Submissions among the files of a class: whose each is, and which of its scripts is marked."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from setcmas_ctrl.scripts.messages import safe_text
from setcmas_simu.errors import SetcmasError
from setcmas_tools.grading.marks import Student
from setcmas_tools.grading.rubric import Rubric
from setcmas_tools.grading.submissions.handed_in import Files, handed_in, is_empty
from setcmas_tools.grading.submissions.identity import Identity, identity_of
from setcmas_tools.grading.submissions.law_file import chosen_script, has_function

_MOST_FILES = 200
_ONES = 'submission'  # folder in which autograders have that of one student
_SUFFIXES = ('.py', '.zip', '.ipynb')

_Part = tuple[str, Identity, PurePosixPath, bytes]
"""Name in the folder of the class, whose it is, path in the submission, and content of a file."""


@dataclass(frozen=True)
class Submission:
    """What a student has handed in.

    Attributes:
        name: Its file or folder, relative to the folder of the class.
        student: Whose it is.
        script: Name of the script that is marked; empty if there is none.
        files: The script and the files beside and below it, by their paths from there.
        problem: Why there is no script to mark; empty if there is one.
    """

    name: str
    student: Student
    script: str = ''
    files: Mapping[str, bytes] = field(default_factory=dict)
    problem: str = ''


def find_submissions(place: Path, rubric: Rubric) -> list[Submission]:
    """Return the submissions in a folder or a zip file, sorted by the names of students.

    Each script, zip file and folder there is one, but for the files that Canvas and Moodle say to
    be of one student. A lone folder with the scripts of several is the class itself.

    Args:
        place: The folder or the zip file.
        rubric: What they are to be marked by.

    Raises:
        SetcmasError: There are none.
    """
    found: defaultdict[str, list[_Part]] = defaultdict(list)
    for path, content in _of_class(handed_in(place), rubric.function).items():
        top = path.parts[0]
        is_file = len(path.parts) == 1
        identity = identity_of(top, path.stem if is_file else PurePosixPath(top).stem)
        if is_file and not identity.group and path.suffix not in _SUFFIXES:
            continue  # nobody's, such as a list of the class
        if is_empty(path) and is_file:
            continue
        own = PurePosixPath(identity.file or top) if is_file else path.relative_to(top)
        found[identity.group or top].append((top, identity, own, content))
    if not found:
        raise SetcmasError(
            f"'{place}' holds no submissions; it must be a folder, or a zip file, with a script "
            'or a folder of each student'
        )
    submissions = [_submission(parts, rubric) for parts in found.values()]
    return sorted(submissions, key=lambda one: (one.student.name.casefold(), one.name))


def _of_class(files: Files, function: str) -> Files:
    """Return files by their paths from the folder of the class, which may lie in another one."""
    top, *others = {path.parts[0] for path in files} or {_ONES}
    if others or top == _ONES or identity_of(top, top).group:
        return files
    inner = {
        PurePosixPath(*path.parts[1:]): content
        for path, content in files.items()
        if len(path.parts) > (2 if is_empty(path) else 1)
    }
    scripts = [path for path in inner if path.suffix == '.py']
    some = {path.parts[0] for path in scripts if has_function(inner[path], function)}
    if len(some) > 1 or any(identity_of(path.parts[0], '').group for path in inner):
        return inner
    deeper = _of_class(inner, function)
    return files if deeper is inner else deeper


def _submission(parts: list[_Part], rubric: Rubric) -> Submission:
    ordered = sorted(parts, key=lambda part: part[1].number)
    newest = [part for part in ordered if not is_empty(part[2])][-_MOST_FILES:]
    files: Files = {path: content for _, _, path, content in newest}
    tops = {path: top for top, _, path, _ in newest}
    last, student = ordered[-1][0], ordered[-1][1].student
    script, problem = chosen_script(files, rubric.function, rubric.exercise)
    shown = safe_text(str, tops.get(script, last))
    if problem:
        return Submission(shown, student, problem=problem)
    folder = script.parent
    beside = {
        path.relative_to(folder).as_posix(): content
        for path, content in files.items()
        if path.is_relative_to(folder)
    }
    return Submission(shown, student, script.name, beside)
