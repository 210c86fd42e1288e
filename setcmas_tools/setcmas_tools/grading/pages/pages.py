"""HTML pages of a graded class: one of the class for teachers, one for each student."""

from __future__ import annotations

import functools
import statistics
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment

from setcmas_tools.grading.marks import Marks
from setcmas_tools.grading.pages.class_figures import (
    bins,
    hardest_first,
    has_failed,
    likeness_pairs,
    share,
)
from setcmas_tools.grading.pages.file_names import file_names
from setcmas_tools.grading.pages.path_picture import path_picture
from setcmas_tools.grading.pages.remarks import names_of, points_text, remark
from setcmas_tools.grading.student_view import student_view
from setcmas_tools.pages.page import rendered, templates, write_page

CLASS_PAGE = 'index.html'
STUDENTS = 'students'


def write_pages(marks: Sequence[Marks], folder: Path) -> Path:
    """Write the pages of a class into a folder that is there; returns the page of the class.

    Args:
        marks: Those of all submissions, at least one.
        folder: Gets `index.html`, and `students` with a page for each submission and no others.

    Raises:
        OSError: They cannot be written.
    """
    names = file_names(marks)
    students = folder / STUDENTS
    students.mkdir(exist_ok=True)
    for old in students.glob('*.html'):
        if old.stem not in names:
            old.unlink()
    for one, name in zip(marks, names, strict=True):
        write_page(students / f'{name}.html', student_page(one))
    page = folder / CLASS_PAGE
    write_page(page, class_page(marks, [f'{STUDENTS}/{name}.html' for name in names]))
    return page


def student_page(marks: Marks) -> str:
    """Return the page of a submission, with nothing on it that its student may not see."""
    return _page('student.html', marks=student_view(marks))


def class_page(marks: Sequence[Marks], links: Sequence[str]) -> str:
    """Return the page of a class, for teachers only.

    Args:
        marks: Those of all submissions, at least one.
        links: The page of each, as a relative address.
    """
    names = names_of(marks)
    rows = list(zip(marks, links, strict=True))
    scores = [one.score for one in marks]
    return _page(
        'class.html', marks=marks, rows=rows, names=names, mean=statistics.fmean(scores),
        median=statistics.median(scores), full=sum(one.is_full for one in marks),
        failed=sum(map(has_failed, marks)), bins=bins(marks), criteria=hardest_first(marks),
        likenesses=likeness_pairs(marks),
    )  # fmt: skip


def _page(template: str, **known: Any) -> str:
    return rendered(_templates(), template, **known)


@functools.cache
def _templates() -> Environment:
    found = templates(__package__)
    found.filters |= {'points': points_text, 'picture': path_picture, 'remark': remark}
    found.globals['share'] = share
    return found
