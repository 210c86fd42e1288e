"""A TurtleBot3 and its motion capture by another maker: Cyclone DDS, without any ROS.

Arguments: ROS domain; what it listens to: TwistStamped, Twist or nothing. Prints `goes` once it
has moved by 5 cm.
"""

import math
import os
import sys
import time

# Fast DDS uses no multicast within a machine.
os.environ['CYCLONEDDS_URI'] = """
<CycloneDDS><Domain>
  <General>
    <AllowMulticast>false</AllowMulticast>
    <Interfaces><NetworkInterface name="lo"/></Interfaces>
  </General>
  <Discovery>
    <ParticipantIndex>auto</ParticipantIndex>
    <MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>
    <Peers><Peer address="localhost"/></Peers>
  </Discovery>
</Domain></CycloneDDS>"""

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import make_idl_struct
from cyclonedds.idl.types import float64, int32, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

STEP_S = 0.02


def message(name, **fields):
    """Return the class of a message as ROS names it in DDS; `name` is such as std_msgs/Header."""
    package, kind = name.split('/')
    return make_idl_struct(kind, f'{package}::msg::dds_::{kind}_', fields)


Time = message('builtin_interfaces/Time', sec=int32, nanosec=uint32)
Header = message('std_msgs/Header', stamp=Time, frame_id=str)
Vector3 = message('geometry_msgs/Vector3', **dict.fromkeys('xyz', float64))
Quaternion = message('geometry_msgs/Quaternion', **dict.fromkeys('xyzw', float64))
Twist = message('geometry_msgs/Twist', linear=Vector3, angular=Vector3)
TwistStamped = message('geometry_msgs/TwistStamped', header=Header, twist=Twist)
Pose = message('geometry_msgs/Pose', position=Vector3, orientation=Quaternion)
PoseStamped = message('geometry_msgs/PoseStamped', header=Header, pose=Pose)


def main():
    participant = DomainParticipant(int(sys.argv[1]))
    kind = {'TwistStamped': TwistStamped, 'Twist': Twist}.get(sys.argv[2])
    poses = DataWriter(
        participant,
        Topic(participant, 'rt/vrpn_mocap/tb3_1/pose', PoseStamped),
        Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(1)),
    )
    commands = kind and DataReader(
        participant,
        Topic(participant, 'rt/tb3_1/cmd_vel', kind),
        Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10)),
    )
    x = 1.0
    y = theta = V = omega = way = 0.0
    while True:
        for command in commands.take(10) if commands else []:
            if isinstance(command, kind):  # not the end of a writer
                twist = getattr(command, 'twist', command)
                V, omega = twist.linear.x, twist.angular.z
        theta += STEP_S * omega
        x += STEP_S * V * math.cos(theta)
        y += STEP_S * V * math.sin(theta)
        if way < 0.05 <= way + STEP_S * abs(V):
            print('goes', flush=True)
        way += STEP_S * abs(V)
        now = time.time()
        stamp = Time(int(now), int(1e9 * (now % 1)))
        place = Vector3(x, y, 0.19 + 1e-6 * math.sin(1e3 * now))
        heading = Quaternion(0.0, 0.0, math.sin(theta / 2), math.cos(theta / 2))
        poses.write(PoseStamped(Header(stamp, 'mocap'), Pose(place, heading)))
        time.sleep(STEP_S)


if __name__ == '__main__':
    main()
