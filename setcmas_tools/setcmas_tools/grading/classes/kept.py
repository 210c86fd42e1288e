"""Marks that are kept from one grading to the next, so that one that was stopped goes on."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import msgspec

from setcmas_simu import __version__
from setcmas_tools.grading.classes.worker import Grader
from setcmas_tools.grading.marks import Marks
from setcmas_tools.grading.submissions.found import Submission
from setcmas_tools.grading.submissions.handed_in import KEPT

_SANDBOX = 2
"""Which one marks are made with; 1 could be left, so that its marks may be forged."""


class KeptMarks:
    """A folder with a file for each submission that is graded."""

    def __init__(self, folder: Path, grader: Grader, in_lab: bool = False) -> None:
        """Open the folder, which is made if it is not there.

        Args:
            folder: The folder of all grades.
            grader: What they are made with; other marks do not count.
            in_lab: Whether they are made in the emulated lab.
        """
        self._folder = folder / KEPT
        self._folder.mkdir(parents=True, exist_ok=True)
        self._grader = _digest(
            repr((__version__, _SANDBOX, grader.times, grader.confined, in_lab)).encode(),
            *(part for file in grader.rubric.files for part in (file.name.encode(), _read(file))),
        )

    def digest(self, submission: Submission) -> str:
        """Return what is the same for submissions that get the same marks."""
        parts = [self._grader.encode(), repr((submission.name, submission.script)).encode()]
        parts += [submission.problem.encode()]
        for name, content in sorted(submission.files.items()):
            parts += [name.encode(errors='surrogateescape'), content]
        return _digest(*parts)

    def found(self, submission: Submission) -> Marks | None:
        """Return the marks of a submission that was graded before, None if it was not."""
        digest = self.digest(submission)
        try:
            marks = msgspec.json.decode((self._folder / f'{digest}.json').read_bytes(), type=Marks)
        except (OSError, msgspec.MsgspecError):
            return None
        return marks if marks.digest == digest else None

    def keep(self, submission: Submission, marks: Marks) -> Marks:
        """Write the marks of a submission, whole or not at all; returns them with their digest."""
        digest = self.digest(submission)
        told = replace(marks, digest=digest)
        part = self._folder / f'{digest}.part'
        part.write_bytes(msgspec.json.encode(told))
        part.replace(part.with_suffix('.json'))
        return told

    def drop_others(self, submissions: Iterable[Submission]) -> None:
        """Remove what is of no submission of these."""
        wanted = {self.digest(one) for one in submissions}
        for file in self._folder.iterdir():
            if file.stem not in wanted and file.suffix in ('.json', '.part'):
                file.unlink()


def _read(file: Path) -> bytes:
    return file.read_bytes() if file.is_file() else b''


def _digest(*parts: bytes) -> str:
    whole = hashlib.sha256()
    for part in parts:
        whole.update(b'%d:' % len(part) + part)
    return whole.hexdigest()
