"""What ends a call of a script from outside."""

from __future__ import annotations


class StopCall(BaseException):
    """Raised in a call of a script by the signal that ends the process."""


class AbandonCall(BaseException):
    """Raised in a stuck call of a script when a new version of the script is there."""
