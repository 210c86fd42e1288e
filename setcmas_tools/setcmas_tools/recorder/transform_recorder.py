"""Topics /tf and /tf_static of a bag, made from the recorded odometry."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, QoSProfile
from rosbags.interfaces import Connection

from setcmas_simu.fleet.topics import TF, TF_STATIC
from setcmas_tools.bags.derived import DERIVED
from setcmas_tools.recorder.message_definitions import Definition, MessageDefinitions
from setcmas_tools.recorder.offered_qos import stored_qos
from setcmas_tools.recorder.transforms import Transform, base_link_of, tf_message, transform_of
from setcmas_tools.recorder.writer import BagWriter

_TYPE = 'tf2_msgs/msg/TFMessage'
_QOS = {  # as tf2's broadcasters offer it
    TF: QoSProfile(depth=100),
    TF_STATIC: QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL),
}


class TransformRecorder:
    """Writes transforms for programs that show a recording, and know no odometry.

    Attributes:
        wanted: Whether they are to be written: not where somebody publishes them.
    """

    def __init__(self, writer: BagWriter) -> None:
        """Write through a writer, from the first odometry on."""
        self.wanted = True
        self._writer = writer
        self._connections: dict[str, Connection] = {}
        self._now: list[Transform] = []
        self._known: set[str] = set()
        self._base_links: list[Transform] = []

    def take(self, odometry: bytes) -> None:
        """Take an odometry that has just been written.

        Raises:
            OSError: The disk is full, or fails.
        """
        transform = transform_of(odometry) if self.wanted else None
        if transform is None:
            return
        if self._now and transform.stamp != self._now[0].stamp:
            self.write()
        self._now.append(transform)

    def write(self) -> None:
        """Write what was taken, robots of one time in one message.

        Raises:
            OSError: The disk is full, or fails.
        """
        transforms, self._now = self._now, []
        if not transforms or not self.wanted:
            return
        self._write(TF, transforms)
        new = {one.child: one for one in transforms if one.child not in self._known}
        self._known |= new.keys()
        if links := [link for one in new.values() if (link := base_link_of(one))]:
            self._base_links += links  # all in one message: it is latched, and the last one counts
            self._write(TF_STATIC, self._base_links)

    def _write(self, topic: str, transforms: list[Transform]) -> None:
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_topic(
                topic, _TYPE, _definition(), stored_qos([_QOS[topic]])
            )
        self._writer.write(self._connections[topic], self._writer.end_ns, tf_message(transforms))


def _definition() -> Definition:
    known = MessageDefinitions([]).of(_TYPE)
    return Definition(DERIVED + known.text, known.digest)
