"""Format of grades: files for a learning platform, or an autograder for it."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_simu.plugins import PluginGroup, instance_of
from setcmas_tools.grade.check import student_view
from setcmas_tools.grade.criteria import points_text
from setcmas_tools.grade.mark_pages import failure_line, file_names
from setcmas_tools.grade.marks import CriterionMark, Failure, Marks, ScenarioMark
from setcmas_tools.grade.rubric import Rubric
from setcmas_tools.platforms.autograder import (
    Kit,
    archive,
    own_wheel,
    package_folders,
    rubric_files,
)
from setcmas_tools.platforms.bundled_plugins import plugin_folders, plugin_wheel, used_packages
from setcmas_tools.platforms.rubric_handout import CHECK, handout

_UTF_8 = '\ufeff'  # shows the encoding to Excel; Moodle and Canvas remove it
_FORMULA = ('=', '+', '-', '@', '＝', '＋', '－', '＠')


def csv_text(rows: Iterable[Iterable[str | float]]) -> str:
    """Return rows as CSV; texts that a spreadsheet would evaluate begin with an apostrophe."""
    text = io.StringIO()
    csv.writer(text, lineterminator='\n').writerows(map(_safe, row) for row in rows)
    return _UTF_8 + text.getvalue()


def _safe(cell: str | float) -> str | float:
    if not isinstance(cell, str):
        return f'{cell:.6g}'
    plain = ' '.join(''.join(c if c.isprintable() else ' ' for c in cell).split())
    return f"'{plain}" if plain.startswith(_FORMULA) else plain


UNFILLED = 'Not filled in yet: this is the original exercise.'


def summary(marks: Marks) -> str:
    """Return what failed and what was corrected by hand; may be empty."""
    lines = [UNFILLED] if marks.unfilled else []
    lines += [failure_text(marks.failure)] if marks.failure else []
    if marks.corrections:
        lines.append(f'{_line("Automatic mark", marks.automatic, marks.max_score)}. Corrections:')
        lines += map(str, marks.corrections)
        lines.append(_line('Corrected mark', marks.score, marks.max_score))
    return '\n'.join(lines)


def marked_file(marks: Marks) -> str:
    """Return a line that names the marked file; '' if there is none."""
    return f'File: {marks.own_file}' if marks.file else ''


def criteria_texts(scenario: ScenarioMark) -> Iterator[tuple[CriterionMark, str]]:
    """Yield each criterion with its values and hint; the first also has the failure."""
    failed = [failure_text(scenario.failure)] if scenario.failure else []
    for mark in scenario.criteria:
        yield mark, '\n'.join(filter(None, [*failed, criterion_text(mark)]))
        failed = []


def criterion_text(mark: CriterionMark) -> str:
    """Return values and hint of a criterion; may be empty."""
    figures = '' if mark.hidden else f'wanted {mark.wanted}, reached {mark.reached_text}'
    return '\n'.join(filter(None, (figures, mark.hint)))


def failure_text(failure: Failure) -> str:
    """Return an error with the lines of the script around it."""
    if not failure.line:
        return failure.message
    lines = [
        f'{">" if number == failure.line else " "} {number:4} {text}'
        for number, text in enumerate(failure.around, start=failure.first)
    ]
    return '\n'.join([failure_line(failure), *lines])


def feedback(marks: Marks) -> str:
    """Return the complete feedback for a student."""
    lines = [line for line in (marked_file(marks), summary(marks)) if line]
    for scenario in marks.scenarios:
        lines.append(_line(scenario.name, scenario.points, scenario.max_points))
        for mark, text in criteria_texts(scenario):
            sign = '✓' if mark.is_full else '✗'
            lines.append(f'{sign} {_line(mark.name, mark.points, mark.max_points)}')
            lines += [text] if text else []
    return '\n'.join(lines)


def _line(name: str, points: float, most: float) -> str:
    return f'{name}: {points_text(points)} of {points_text(most)}'


Files = Mapping[str, str | bytes]
"""Contents of files by path, with / between folders."""


@dataclass(frozen=True)
class GradeFormat:
    """A format of grades.

    Attributes:
        purpose: Its reader, in one line.
        files: Returns the files of a graded class with at least one submission.
        bundle: Returns the files for grading on the platform; None if not supported.
    """

    purpose: str
    files: Callable[[Sequence[Marks]], Files]
    bundle: Callable[[Kit], Files] | None = None


GRADE_FORMATS: PluginGroup[GradeFormat] = PluginGroup(
    'setcmas.grade_formats', 'grade format', instance_of(GradeFormat)
)
"""Installed formats."""

CLASS_FORMATS = ('csv', 'moodle', 'canvas', 'junit')
"""Default formats of a class."""


def result_files(folder: str, result: Callable[[Marks], Mapping[str, Any]]) -> Any:
    """Return the function `files` of a format with a JSON file per submission.

    Args:
        folder: Folder of the files.
        result: Returns the content for the marks of a submission, as its student may see them.
    """

    def files(marks: Sequence[Marks]) -> Files:
        contents = [_json(result(student_view(one))) for one in marks]
        names = [f'{folder}/{name}.json' for name in file_names(marks)]
        return dict(zip(names, contents, strict=True))

    return files


def _json(content: Mapping[str, Any]) -> str:
    return json.dumps(content, indent=1, ensure_ascii=False) + '\n'


def format_files(names: Iterable[str], marks: Sequence[Marks]) -> dict[str, bytes]:
    """Return the files of a graded class in several formats: contents by path.

    Raises:
        SetcmasError: A format is unknown.
    """
    files = {}
    for format_ in [GRADE_FORMATS.get(name) for name in names]:
        for path, content in format_.files(marks).items():
            files[path] = content.encode(errors='replace') if isinstance(content, str) else content
    return files


def write_files(files: Mapping[str, bytes], folder: Path) -> list[Path]:
    """Write files into a folder, and return their paths; an OSError is raised if this fails."""
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return [folder / name for name in files]


def make_bundle(name: str, rubric: Rubric, options: str = '') -> bytes:
    """Return the zip archive for automatic grading on a platform, or for students' checks.

    Args:
        name: Name of the format, or CHECK.
        rubric: The rubric.
        options: Further options of `setcmas grade` on the platform.

    Raises:
        SetcmasError: The format is unknown or has no bundle, a file of the rubric is outside
            its folder, or a package that it uses cannot be carried.
    """
    if name == CHECK:
        return handout(rubric)
    bundle = GRADE_FORMATS.get(name).bundle
    if bundle is None:
        platforms = (one for one in GRADE_FORMATS.plugins() if GRADE_FORMATS.get(one).bundle)
        known = ', '.join((CHECK, *platforms))
        raise SetcmasError(f"format '{name}' has no bundle; --make must be one of {known}")
    wheel, content = own_wheel()
    packages = used_packages(rubric)
    plugins = dict(plugin_wheel(package, one) for package, one in packages.items())
    shipped = [*package_folders().values()]
    shipped += [folder for one in packages.values() for folder in plugin_folders(one).values()]
    files = rubric_files(rubric.file, rubric.files, shipped)
    kit = Kit(
        rubric.title,
        wheel,
        {wheel: content, **plugins, **files},
        f'rubric/{rubric.file.name}',
        options,
        tuple(plugins),
    )
    return archive(bundle(kit))
