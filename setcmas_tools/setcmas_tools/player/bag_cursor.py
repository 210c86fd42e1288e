"""Cursor in a bag: its messages in the order of time, from any moment on."""

from __future__ import annotations

from collections import deque
from collections.abc import Container, Iterator

from setcmas_tools.bags.reader import Bag, BagTopic

KEPT = 1000
"""How many messages of a latched topic somebody gets who comes late."""

Played = tuple[BagTopic, bytes]


class BagCursor:
    """Hands out the messages of some topics up to a time.

    Attributes:
        duration: Time of the last message of the bag in s from its first one.
    """

    def __init__(
        self, bag: Bag, topics: Container[BagTopic], latched: Container[BagTopic]
    ) -> None:
        """Stand at the first message.

        Args:
            bag: Where the messages come from.
            topics: Those that are handed out.
            latched: Those of which older messages count, too.
        """
        self._bag = bag
        self._topics = topics
        self._latched = latched
        self.duration = (bag.end_ns - bag.start_ns) / 1e9
        self._messages: Iterator[tuple[BagTopic, int, bytes]] = iter(())
        self._next: tuple[BagTopic, int, bytes] | None = None
        self.move_to(0.0)

    @property
    def next_s(self) -> float | None:
        """Time of the next message in s; None at the end."""
        return (self._next[1] - self._bag.start_ns) / 1e9 if self._next else None

    def until(self, at: float) -> Iterator[Played]:
        """Yield the messages up to a time in s that were not handed out yet."""
        while self._next and (self._next[1] - self._bag.start_ns) / 1e9 <= at:
            topic, _, data = self._next
            self._next = next(self._messages, None)
            yield topic, data

    def move_to(self, at: float) -> list[Played]:
        """Stand at the first message from a time in s on.

        Returns:
            The messages of latched topics before it, that would be known by then.
        """
        self._messages = (one for one in self._bag.messages() if one[0] in self._topics)
        self._next = next(self._messages, None)
        kept: dict[BagTopic, deque[bytes]] = {}
        while self._next and (self._next[1] - self._bag.start_ns) / 1e9 < at:
            topic, _, data = self._next
            if topic in self._latched:
                kept.setdefault(topic, deque(maxlen=KEPT)).append(data)
            self._next = next(self._messages, None)
        return [(topic, data) for topic, messages in kept.items() for data in messages]
