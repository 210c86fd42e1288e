"""Failure of a function that a script defines."""

from __future__ import annotations

from pathlib import Path

from setcmas_ctrl.scripts.messages import describe_failure, script_place


class ControlError(Exception):
    """A call of `control` failed.

    Attributes:
        key: The same for errors that a student would call the same.
        consequence: What happens to the robot, after its name; empty if it is as usual.
    """

    def __init__(self, message: str, key: object, consequence: str = '') -> None:
        """Store the message, what identifies the error, and what comes of it."""
        super().__init__(message)
        self.key = key
        self.consequence = consequence


def failure_of(error: BaseException, path: Path) -> ControlError:
    """Return what to tell of an error that a function of a script raised."""
    key = (type(error).__name__, *script_place(error, path))
    return ControlError(describe_failure(error, path), key)
