"""Motion capture that sends all bodies on one topic, by another maker: Cyclone DDS, without ROS.

Arguments: ROS domain, 'poses' or 'rigid_bodies', and a JSON file with what it sees at present: a
list of [name, x, y, heading].
"""

import json
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import int8, int32, sequence, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from foreign_robot import Header, Pose, Quaternion, Time, Vector3  # sets Cyclone DDS up

STEP_S = 0.02


@dataclass
class NamedPose(IdlStruct, typename='motion_capture_tracking_interfaces::msg::dds_::NamedPose_'):
    name: str
    pose: Pose


@dataclass
class NamedPoseArray(
    IdlStruct, typename='motion_capture_tracking_interfaces::msg::dds_::NamedPoseArray_'
):
    header: Header
    poses: sequence[NamedPose]


@dataclass
class Marker(IdlStruct, typename='mocap4r2_msgs::msg::dds_::Marker_'):
    id_type: int8
    marker_index: int32
    marker_name: str
    translation: Vector3


@dataclass
class RigidBody(IdlStruct, typename='mocap4r2_msgs::msg::dds_::RigidBody_'):
    rigid_body_name: str
    markers: sequence[Marker]
    pose: Pose


@dataclass
class RigidBodies(IdlStruct, typename='mocap4r2_msgs::msg::dds_::RigidBodies_'):
    header: Header
    frame_number: uint32
    rigidbodies: sequence[RigidBody]


def rigid_body(name, pose):
    return RigidBody(name, [Marker(1, 0, '', pose.position)], pose)


def main():
    domain, topic, seen = sys.argv[1:]
    kind = {'poses': NamedPoseArray, 'rigid_bodies': RigidBodies}[topic]
    participant = DomainParticipant(int(domain))
    writer = DataWriter(
        participant,
        Topic(participant, f'rt/{topic}', kind),
        Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(1)),
    )
    frame = 0
    while True:
        frame += 1
        now = time.time()
        header = Header(Time(int(now), int(1e9 * (now % 1))), 'mocap')
        height = 0.19 + 1e-6 * math.sin(frame)  # noise, as a real system has
        poses = [
            (name, Pose(Vector3(x, y, height), Quaternion(0.0, 0.0, *half_angle(theta))))
            for name, x, y, theta in json.loads(Path(seen).read_text())
        ]
        if kind is NamedPoseArray:
            writer.write(NamedPoseArray(header, [NamedPose(*pose) for pose in poses]))
        else:
            writer.write(RigidBodies(header, frame, [rigid_body(*pose) for pose in poses]))
        time.sleep(STEP_S)


def half_angle(theta):
    return math.sin(theta / 2), math.cos(theta / 2)


main()
