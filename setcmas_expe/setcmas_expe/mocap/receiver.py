"""Receiver of motion capture: each measurement goes to whoever waits for its rigid body."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile

from setcmas_expe.mocap.sample import Sample
from setcmas_expe.mocap.sources import NAME, MocapSource
from setcmas_simu.ros import qos

Take = Callable[[Sample], None]


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
        self._rivals: dict[str, str] = {}  # by topic
        self._twice: set[str] = set()
        self._unreadable = ''
        self._named: set[str] = set()
        message_class = source.message_class()
        # A driver with one topic for all is listened to once.
        topics = {source.topic_of(body): body for body in bodies}
        for topic, body in topics.items():
            callback = partial(self._on_message, body)
            node.create_subscription(message_class, topic, callback, profile)

    def look_around(self) -> None:
        """See who sends the poses.

        A second sender may be an emulated lab or a bag that is played: its poses are as plausible.
        """
        for topic in {self._source.topic_of(body) for body in self._bodies}:
            senders = self._node.count_publishers(topic)
            told = f'{senders} nodes send it on {topic}' if senders > 1 else ''
            self._rivals[topic] = told

    def trouble(self, body: str) -> str:
        """Return why no pose of a body is to be believed; empty if they may be."""
        topic = self._source.topic_of(body)
        if self._unreadable:
            return f'messages on {topic} cannot be read: {self._unreadable}'
        if body in self._twice:
            return f"two bodies are called '{body}' on {topic}"
        return self._rivals.get(topic, '')

    def bodies(self) -> list[str]:
        """Return the names of the bodies that motion capture sends at present, sorted."""
        if not self._source.per_body:
            return sorted(self._named)
        before, _, after = self._source.topic.partition(NAME)
        after = after.partition(NAME)[0]
        return sorted(
            name[len(before) :].partition(after or '\n')[0]
            for name, _ in self._node.get_topic_names_and_types()
            if name.startswith(before) and after in name and self._node.count_publishers(name)
        )

    def _on_message(self, body: str, message: Any) -> None:
        try:
            samples = self._source.samples(message, body)
        except Exception as error:  # of a plugin: its bodies are not seen, the others are safe
            self._unreadable = f'{type(error).__name__}: {error}'
            return
        times = Counter(name for name, _ in samples)
        self._unreadable = ''
        self._named = set(times)
        self._twice -= times.keys()
        self._twice |= {name for name, count in times.items() if count > 1}
        for name, sample in samples:
            if name in self._bodies and name not in self._twice:
                self._bodies[name](sample.z_up() if self._y_up else sample)
