"""Driver of the emulated motion capture system: topics and types of the lab's preset."""

from __future__ import annotations

from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion, TransformStamped, Vector3
from nav_msgs.msg import Odometry

from setcmas_expe.emulation.mocap import Sighting
from setcmas_expe.lab.model import Lab
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import FleetNode


class EmulatedMocapDriver(FleetNode):
    """Publishes sightings, best effort as real drivers do."""

    def __init__(self, lab: Lab) -> None:
        """Create the node with a publisher for each robot of the lab."""
        super().__init__(f'{lab.mocap.preset}_driver')
        self._type = lab.mocap.source.message_class()
        self._bodies = [
            self.create_publisher(
                self._type,
                lab.mocap.topic_of(robot),
                qos.SENSOR,
            )
            for robot in lab.robots
        ]

    def publish(self, sighting: Sighting, stamp: float) -> None:
        """Publish a sighting under the name of its body, with a stamp in s since 1970."""
        self._bodies[sighting.body].publish(self._message(sighting, stamp))

    def _message(self, sighting: Sighting, stamp: float) -> Any:
        x, y, z = sighting.position
        rotation = Quaternion(**dict(zip('xyzw', sighting.quaternion, strict=True)))
        message = self._type()
        message.header.stamp = Time(sec=int(stamp), nanosec=int(1e9 * (stamp % 1)))
        message.header.frame_id = 'mocap'
        if isinstance(message, TransformStamped):
            message.transform.translation = Vector3(x=x, y=y, z=z)
            message.transform.rotation = rotation
        else:
            pose = message.pose.pose if isinstance(message, Odometry) else message.pose
            pose.position, pose.orientation = Point(x=x, y=y, z=z), rotation
        return message
