"""Receiver of motion capture: each measurement goes to whoever waits for its rigid body."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile

from setcmas_expe.mocap.sample import Sample
from setcmas_expe.mocap.sources import NAME, MocapSource
from setcmas_simu.ros import qos

Take = Callable[[Sample], None]


@dataclass
class _Heard:
    """What the last message on a topic was, and who sends there.

    Attributes:
        names: The bodies in it.
        twice: Those that are in it twice.
        unreadable: Why it could not be read; empty if it could.
        rivals: Who else sends on the topic; empty if nobody.
    """

    names: set[str] = field(default_factory=set)
    twice: set[str] = field(default_factory=set)
    unreadable: str = ''
    rivals: str = ''


class MocapReceiver:
    """Subscribes to a source, and tells whose poses are not to be believed."""

    def __init__(
        self,
        node: Node,
        source: MocapSource,
        y_up: bool,
        bodies: Mapping[str, Take],
        profile: QoSProfile = qos.SENSOR,
    ) -> None:
        """Start to listen.

        Args:
            node: The node that listens.
            source: What the driver sends.
            y_up: Whether the y axis of the system points upwards.
            bodies: Who takes the measurements of each body, Z-up.
            profile: Quality of service, best effort.

        Raises:
            SetcmasError: The package of the messages is not installed.
        """
        self._node = node
        self._source = source
        self._y_up = y_up
        self._bodies = bodies
        self._heard: dict[str, _Heard] = {}  # by topic: one that tells of all bodies is one
        message_class = source.message_class()
        for body in bodies:
            topic = source.topic_of(body)
            if topic not in self._heard:
                self._heard[topic] = heard = _Heard()
                callback = partial(self._on_message, heard, body)
                node.create_subscription(message_class, topic, callback, profile)

    def look_around(self) -> None:
        """See who sends the poses.

        A second sender may be an emulated lab or a bag that is played: its poses are as plausible.
        """
        for topic, heard in self._heard.items():
            senders = self._node.count_publishers(topic)
            several = senders > 1 and not self._source.shared
            heard.rivals = f'{senders} nodes send it on {topic}' if several else ''

    def trouble(self, body: str) -> str:
        """Return why no pose of a body is to be believed; empty if they may be."""
        topic = self._source.topic_of(body)
        heard = self._heard[topic]
        if heard.unreadable:
            return f'messages on {topic} cannot be read: {heard.unreadable}'
        if body in heard.twice:
            return f"two bodies are called '{body}' on {topic}"
        return heard.rivals

    def bodies(self) -> list[str]:
        """Return the names of the bodies that motion capture sends at present, sorted."""
        if not self._source.per_body:
            return sorted(name for heard in self._heard.values() for name in heard.names)
        before, _, after = self._source.topic.partition(NAME)
        after = after.partition(NAME)[0]
        return sorted(
            name[len(before) :].partition(after or '\n')[0]
            for name, _ in self._node.get_topic_names_and_types()
            if name.startswith(before) and after in name and self._node.count_publishers(name)
        )

    def _on_message(self, heard: _Heard, body: str, message: Any) -> None:
        try:
            samples = self._source.samples(message, body)
        except Exception as error:  # of a plugin; the bodies of other topics are seen
            heard.unreadable = ' '.join(f'{type(error).__name__}: {error}'.split())
            return
        times = Counter(name for name, _ in samples)
        heard.unreadable = ''
        heard.names = set(times)
        heard.twice = {name for name, count in times.items() if count > 1}
        for name, sample in samples:
            if name in self._bodies and name not in heard.twice:
                self._bodies[name](sample.z_up() if self._y_up else sample)
