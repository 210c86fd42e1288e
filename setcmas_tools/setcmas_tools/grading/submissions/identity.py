"""Whose a submission is, by the names that learning platforms give to files and folders."""

from __future__ import annotations

import re
from dataclasses import dataclass

from setcmas_tools.grading.marks import Student

_MOODLE = re.compile(r'(?P<name>.+?)_(?P<id>\d+)_assignsubmission_[a-z]+_?(?P<file>.*)')
_CANVAS = re.compile(r'(?P<name>[^_]+)_(LATE_)?(?P<id>\d+)_(?P<number>\d+)_(?P<file>.+)')
_AGAIN = re.compile(r'-\d+(?=\.\w+$)')
"""What Canvas adds to the name of a file that is handed in again."""


@dataclass(frozen=True)
class Identity:
    """Whose a file or a folder is.

    Attributes:
        student: The student.
        group: The same for all files of a submission; empty if the file is one by itself.
        number: Of several files of a name, the one with the largest number counts.
        file: What the student called the file; empty if it is not told.
    """

    student: Student
    group: str = ''
    number: int = 0
    file: str = ''


def identity_of(name: str, stem: str) -> Identity:
    """Return whose a file or a folder is.

    Moodle says 'Ada Lovelace_12345_assignsubmission_file_', with the file behind it where it makes
    no folders; Canvas says 'lovelaceada_LATE_123_4567_law-1.py'. Others are taken as they are.

    Args:
        name: The name.
        stem: The same without a file's suffix.
    """
    if found := _MOODLE.fullmatch(name):
        return Identity(_student(found['name'], found['id']), found['id'], file=found['file'])
    if found := _CANVAS.fullmatch(name):
        file = _AGAIN.sub('', found['file'])
        group = f'{found["name"]}_{found["id"]}'
        return Identity(_student(found['name'], found['id']), group, int(found['number']), file)
    return Identity(_student(stem.replace('_', ' '), stem if '@' in stem else ''))


def _student(name: str, number: str) -> Student:
    return Student(name, number, number if '@' in number else '')
