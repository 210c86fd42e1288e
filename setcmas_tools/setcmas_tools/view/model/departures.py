"""Departures of topics that nobody publishes any more, told a while later."""

from __future__ import annotations

from collections.abc import Collection

GRACE_S = 3.0
"""A run that ends takes its topics away one by one; what they told is to stay with it."""


class Departures:
    """Tells which topics have gone for good, or have come back as those of somebody else."""

    def __init__(self) -> None:
        """Start without topics."""
        self._known: set[str] = set()
        self._since: dict[str, float] = {}

    def look(self, there: Collection[str], now: float) -> set[str]:
        """Return the topics whose content counts no more.

        Args:
            there: Those that somebody publishes.
            now: Time in s.
        """
        for name in self._known.difference(there):
            self._since.setdefault(name, now)
        over = {name for name, since in self._since.items() if now - since >= GRACE_S}
        dropped = over | self._since.keys() & set(there)
        for name in dropped:
            del self._since[name]
        self._known = self._known.union(there) - over
        return dropped
