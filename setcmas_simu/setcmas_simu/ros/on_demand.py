"""Publisher that publishes only while some node subscribes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.publisher import Publisher


class OnDemandPublisher:
    """Publishes messages for those who subscribe: asking takes a hundredth of publishing."""

    def __init__(self, publisher: Publisher, always: bool = False) -> None:
        """Publish through a publisher; `always` publishes without subscribers, too."""
        self.publisher = publisher
        self._always = always
        self._nb_subscribers = 0

    def publish(self, encode: Callable[[], Any]) -> None:
        """Publish the message that a function returns, encoded or not."""
        if self._always:
            self.publisher.publish(encode())
            return
        self._nb_subscribers = self.publisher.get_subscription_count()
        if self._nb_subscribers:
            self.publisher.publish(encode())

    @property
    def has_newcomers(self) -> bool:
        """Whether a node has subscribed since the last message."""
        return not self._always and self.publisher.get_subscription_count() > self._nb_subscribers
