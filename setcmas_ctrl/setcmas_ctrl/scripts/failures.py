"""Failure of a function that a script defines."""

from __future__ import annotations

from pathlib import Path

from setcmas_ctrl.scripts.messages import describe_failure, script_place


class ControlError(Exception):
    """A call of `control` failed.

    Attributes:
        key: The same for errors that a student would call the same.
        consequence: What happens to the robot, after its name; empty if it is as usual.
        place: File and line that failed, if they are known.
    """

    def __init__(
        self,
        message: str,
        key: object,
        consequence: str = '',
        place: tuple[Path, int | None] | None = None,
    ) -> None:
        """Store the message, what identifies the error, what comes of it, and where it was."""
        super().__init__(message)
        self.key = key
        self.consequence = consequence
        self.place = place


def failure_of(error: BaseException, path: Path) -> ControlError:
    """Return what to tell of an error that a function of a script raised."""
    place = script_place(error, path)
    return ControlError(describe_failure(error, path), (type(error).__name__, *place), place=place)
