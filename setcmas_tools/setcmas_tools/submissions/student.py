"""Student of a submission, as known from the names of files."""

from __future__ import annotations

import re
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
_CANVAS = re.compile(r'(?P<name>[^_]+)_(LATE_)?(?P<id>\d+)_(?P<number>\d+)_(?P<file>.+)')
_AGAIN = re.compile(r'-\d+(?=\.\w+$)')
"""Suffix that Canvas adds to the name of a file that is submitted again."""


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


def identity_of(name: str, stem: str) -> Identity:
    """Return the identity of a file or folder.

    Moodle uses 'Ada Lovelace_12345_assignsubmission_file_', followed by the file name if it makes
    no folders; Canvas uses 'lovelaceada_LATE_123_4567_law-1.py'. Other names are used as they are.
    The stem is the name without a file's suffix.
    """
    if found := _MOODLE.fullmatch(name):
        group = f'{found["name"]}_{found["id"]}'  # two students with one number stay two
        return Identity(_student(found['name'], found['id']), group, file=found['file'])
    if found := _CANVAS.fullmatch(name):
        file = _AGAIN.sub('', found['file'])
        group = f'{found["name"]}_{found["id"]}'
        return Identity(_student(found['name'], found['id']), group, int(found['number']), file)
    return Identity(_student(stem.replace('_', ' '), stem if '@' in stem else ''))


def _student(name: str, number: str) -> Student:
    return Student(name, number, number if '@' in number else '')
