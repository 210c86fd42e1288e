"""Student of a submission, as known from the names of files."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Student:
    """The student of a submission, as known from file names; '' for what is unknown.

    Attributes:
        name: For example 'Ada Lovelace'; may contain anything, so pages must escape it.
        id: Number or login on the learning platform.
    """

    name: str
    id: str = ''
    email: str = ''


_MOODLE = re.compile(r'(?P<name>.+?)_(?P<id>\d+)_assignsubmission_[a-z]+_?(?P<file>.*)')
_CANVAS = re.compile(
    r'(?:(?P<anonymous>anon_[^\W_]+)(?:_LATE)?|(?P<name>[^_]+)_(?:LATE_)?(?P<id>\d+))_'
    r'(?:(?P<number>\d+)_(?P<file>.+)|(?:text|link)\.html)'
)
_HANDED_IN = re.compile(r'\.(py|ipynb|zip)$')
_AGAIN = re.compile(r'-\d+(?=\.\w+$)')


@dataclass(frozen=True)
class Identity:
    """The student and the origin of a file or folder.

    Attributes:
        student: The student.
        group: Equal for all files of a submission; '' if the file is a submission by itself.
        number: Of several files with the same name, the largest number counts.
        file: The student's own name of the file; '' if unknown.
    """

    student: Student
    group: str = ''
    number: int = 0
    file: str = ''


def identity_of(name: str) -> Identity:
    """Return the identity of a file or folder.

    Moodle uses 'Ada Lovelace_12345_assignsubmission_file_', followed by the file name if it makes
    no folders; Canvas uses 'lovelaceada_LATE_123_4567_law.py', or 'anon_h7KqZ_4567_law.py'.
    Other names are used as they are.
    """
    if found := _MOODLE.fullmatch(name):
        group = f'{found["name"]}_{found["id"]}'  # two students with one number stay two
        return Identity(_student(found['name'], found['id']), group, file=found['file'])
    if found := _CANVAS.fullmatch(name):
        student = _student(found['anonymous'] or found['name'], found['id'] or '')
        group = f'{student.name}_{student.id}'
        return Identity(student, group, int(found['number'] or 0), found['file'] or '')
    stem = _HANDED_IN.sub('', name)
    return Identity(_student(stem.replace('_', ' '), stem if '@' in stem else ''))


def own_names(names: Sequence[str]) -> list[str]:
    """Return the names of a student's files without the -1, -2 that Canvas adds to new versions.

    Names that would be equal stay as they are: they may be the student's own.
    """
    plain = [_AGAIN.sub('', name) for name in names]
    return [one if plain.count(one) == 1 else name for one, name in zip(plain, names, strict=True)]


def _student(name: str, number: str) -> Student:
    return Student(name, number, number if '@' in number else '')
