"""The mocap4r2 drivers (Optitrack, Qualisys, Vicon): one topic with all rigid bodies.

Names are those of the system: such as '3' for Optitrack, and 'Red.Red' for Vicon.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from setcmas_expe.mocap.messages import sample_of
from setcmas_expe.mocap.sample import Sample
from setcmas_expe.mocap.sources import REPEATED, SILENCE, ZEROS, MocapSource


def read_rigid_bodies(message: Any) -> Iterator[tuple[str, Sample]]:
    """Read a mocap4r2_msgs/RigidBodies; the header of the whole frame counts."""
    for body in message.rigidbodies:
        pose = body.pose
        yield body.rigid_body_name, sample_of(message.header, pose.position, pose.orientation)


SOURCE = MocapSource(
    '/rigid_bodies',
    'mocap4r2_msgs/msg/RigidBodies',
    read_rigid_bodies,
    (SILENCE, REPEATED, ZEROS),
    driver='mocap4ros2_optitrack, _qualisys, _nokov (mocap4r2_msgs)',
)
