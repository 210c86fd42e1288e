"""Source of a robot's commands: the one process that a guard follows."""

from __future__ import annotations

from collections.abc import Set as AbstractSet


class Source:
    """Pins who commands a robot, by the identifier that DDS gives to a process.

    Who sent a message cannot be told (rclpy does not say), so nobody is followed while there are
    several. The operator's pause node stands by to command zero: it does not count.

    Attributes:
        pinned: The process that is followed; empty if there is none.
    """

    def __init__(self) -> None:
        """Begin without any."""
        self.pinned = b''

    def conflict(self, found: AbstractSet[bytes], operator: bytes | None, free: bool) -> str:
        """Return why nobody is to be followed; empty if there is one, or none.

        Args:
            found: The processes that publish commands.
            operator: That of the pause node; None if it is not known.
            free: Whether the robot may move now: then nobody may take the place of another.
        """
        rest = found - {operator} if len(found) > 1 else found
        if len(rest) > 1:
            return 'several nodes command it'
        now = next(iter(rest), b'')
        if now and now != self.pinned and self.pinned and free:
            return 'another node commands it than at the start'
        if now or not free:
            self.pinned = now
        return ''
