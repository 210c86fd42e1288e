"""Receiver of motion capture: passes each measurement on to the owner of its rigid body."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile

from setcmas_expe.mocap.sources import MocapSource, Sample
from setcmas_simu.ros import qos
from setcmas_simu.ros.polling import PolledTopic

Take = Callable[[Sample], None]


@dataclass
class _Topic:
    """The bodies in the last message on a topic, those that are in it twice, and conflicts.

    Attributes:
        unreadable: Why the message could not be read; empty if it could.
        conflict: Who else sends on the topic, or that its type is another; empty if neither.
    """

    names: set[str] = field(default_factory=set)
    twice: set[str] = field(default_factory=set)
    unreadable: str = ''
    conflict: str = ''


class MocapReceiver:
    """Subscribes to a source, and finds conflicts between senders.

    Attributes:
        polled: Its topics.
    """

    def __init__(
        self,
        node: Node,
        source: MocapSource,
        y_up: bool,
        bodies: Mapping[str, Take],
        profile: QoSProfile = qos.SENSOR,
    ) -> None:
        """Start to listen, with a callback for the measurements (Z-up) of each body.

        Raises:
            SetcmasError: The package of the messages is not installed.
        """
        self._node = node
        self._source = source
        self._y_up = y_up
        self._bodies = bodies
        self._topics: dict[str, _Topic] = {}  # by name; one for all bodies, or one for each
        self.polled: list[PolledTopic] = []
        message_class = source.message_class()
        for body in bodies:
            name = source.topic_of(body)
            if name not in self._topics:
                self._topics[name] = topic = _Topic()
                callback = partial(self._on_message, topic, body)
                self.polled.append(PolledTopic(node, message_class, name, callback, profile))

    def take(self) -> None:
        """Take new messages, unless a `RequestWait` already does when they come."""
        for topic in self.polled:
            topic.take()

    def look_around(self) -> None:
        """Check for senders of another type, and a second one: an emulated lab, a played bag."""
        for name, topic in self._topics.items():
            types = {one.topic_type for one in self._node.get_publishers_info_by_topic(name)}
            senders = self._node.count_publishers(name)
            several = senders > 1 and not self._source.shared
            topic.conflict = f'{senders} nodes send it on {name}' if several else ''
            if types and self._source.message_type not in types:
                topic.conflict = (
                    f'{name} carries {", ".join(sorted(types))}, but the lab file expects '
                    f'{self._source.message_type} (mocap: preset and type)'
                )

    def trouble(self, body: str) -> str:
        """Return why poses of a body cannot be trusted; empty if they can."""
        name = self._source.topic_of(body)
        topic = self._topics[name]
        if topic.unreadable:
            return f'messages on {name} cannot be read: {topic.unreadable}'
        if body in topic.twice:
            return f"two bodies are called '{body}' on {name}"
        return topic.conflict

    def bodies(self) -> list[str]:
        """Return the names of the bodies that motion capture sends now, sorted."""
        if not self._source.per_body:
            return sorted(name for topic in self._topics.values() for name in topic.names)
        topics = (name for name, _ in self._node.get_topic_names_and_types())
        return self._source.bodies_in(filter(self._node.count_publishers, topics))

    def _on_message(self, topic: _Topic, body: str, message: Any) -> None:
        try:
            samples = self._source.samples(body, message)
        except Exception as error:  # in a plugin; other topics continue
            topic.unreadable = ' '.join(f'{type(error).__name__}: {error}'.split())
            return
        times = Counter(name for name, _ in samples)
        topic.unreadable = ''
        topic.names = set(times)
        topic.twice = {name for name, count in times.items() if count > 1}
        for name, sample in samples:
            if name in self._bodies and name not in topic.twice:
                self._bodies[name](sample.z_up() if self._y_up else sample)
