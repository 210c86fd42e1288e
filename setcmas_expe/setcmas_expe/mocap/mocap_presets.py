"""Presets: the motion capture drivers that a lab file can name."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from setcmas_expe.mocap.sources import (
    ODOMETRY,
    POSE_STAMPED,
    MocapSource,
    Read,
    Sample,
    per_body,
    sample_of,
)
from setcmas_simu.fleet.topics import TF

QUALISYS = per_body(
    '/qualisys/{name}/odom', ODOMETRY, 'motion_capture_system (KumarRobotics, KTH-SML), for ROS 1'
)
VRPN = per_body('/vrpn_mocap/{name}/pose', POSE_STAMPED, 'vrpn_mocap 1.1.0 and 1.2.0')
OPTITRACK = per_body(
    '/{name}/pose', POSE_STAMPED, 'mocap_optitrack 1.1.0, topics by its mocap.yaml'
)
NATNET = per_body('/{name}/pose', POSE_STAMPED, 'natnet_ros2 (L2S-lab), commit 3e3f8d3')
NOKOV = per_body('/{name}/pose', POSE_STAMPED, 'not verified')
VICON = per_body(
    '/vicon/{name}/{name}', POSE_STAMPED, 'vicon_receiver 0.1.1 (ros2-vicon-receiver)'
)
CAMERA = per_body('/camera/{name}/pose', POSE_STAMPED, 'setcmas camera')
WHEEL_ODOMETRY = per_body(
    '/{name}/odom', ODOMETRY, 'turtlebot3_node, from start poses in the lab file', from_start=True
)


def _read_all(bodies: str, name: str) -> Read:
    """Return a reader of messages with one header and a list of named poses."""

    def read(message: Any) -> Iterator[tuple[str, Sample]]:
        for body in getattr(message, bodies):
            pose = body.pose
            yield getattr(body, name), sample_of(message.header, pose.position, pose.orientation)

    return read


MOCAP4R2 = MocapSource(
    '/rigid_bodies',
    'mocap4r2_msgs/msg/RigidBodies',
    _read_all('rigidbodies', 'rigid_body_name'),
    driver='mocap4ros2_optitrack, _qualisys, _nokov (mocap4r2_msgs)',
)
MOTION_CAPTURE_TRACKING = MocapSource(
    '/poses',
    'motion_capture_tracking_interfaces/msg/NamedPoseArray',
    _read_all('poses', 'name'),
    driver='motion_capture_tracking 1.0.9',
)


def read_transforms(message: Any) -> Iterator[tuple[str, Sample]]:
    """Read a tf2_msgs/TFMessage; bodies are child frames, whatever the parents."""
    for one in message.transforms:
        pose = one.transform
        yield one.child_frame_id, sample_of(one.header, pose.translation, pose.rotation)


TRANSFORMS = MocapSource(
    TF,
    'tf2_msgs/msg/TFMessage',
    read_transforms,
    shared=True,
    driver='any; tf2_msgs must be installed',
)
