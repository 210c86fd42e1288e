"""Time of message stamps: the system clock or simulated time."""

from __future__ import annotations

import time
from collections.abc import Callable

from builtin_interfaces.msg import Time

now_ns: Callable[[], int] = time.time_ns
"""Returns the time in ns; a process that follows a simulation replaces it."""


def stamp() -> Time:
    """Return the current time."""
    seconds, nanoseconds = divmod(now_ns(), 10**9)
    return Time(sec=seconds, nanosec=nanoseconds)
