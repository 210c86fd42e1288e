"""Exceptions that end a call of a script from outside."""

from __future__ import annotations

import signal


class StopCall(BaseException):
    """Raised in a call of a script by the signal that ends the process."""


class AbandonCall(BaseException):
    """Raised in a stuck call of a script when a new version of the script is there."""


def scripts_own(_: KeyboardInterrupt) -> bool:
    """Return whether a KeyboardInterrupt is the script's own, as Ctrl-C is handled otherwise."""
    return signal.getsignal(signal.SIGINT) is not signal.default_int_handler
