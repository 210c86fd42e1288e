"""Types of options: numbers that are checked where they are typed."""

from __future__ import annotations

import argparse
import math

MAX_RATE_HZ = 200.0


def number(text: str) -> float:
    """Return the number that a text tells; NaN if it tells none, which no option accepts."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def positive(text: str) -> float:
    """Return a finite number above 0 (type of an option)."""
    value = number(text)
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number above 0")
    return value


def rate(text: str) -> float:
    """Return a rate in Hz that a process can keep (type of an option)."""
    value = positive(text)
    if value > MAX_RATE_HZ:
        raise argparse.ArgumentTypeError(f"'{text}' Hz is above {MAX_RATE_HZ:g} Hz")
    return value


def count(text: str) -> int:
    """Return a whole number of robots from 1 (type of an option)."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of robots from 1")
    return int(text)


def not_negative(text: str) -> float:
    """Return a finite number from 0 (type of an option)."""
    value = number(text)
    if not (math.isfinite(value) and value >= 0):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number from 0")
    return value


def probability(text: str) -> float:
    """Return a number from 0 to 1 (type of an option)."""
    value = number(text)
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number from 0 to 1")
    return value
