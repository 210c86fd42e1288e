"""A control law of one robot by another maker: Cyclone DDS, without ROS.

Arguments: ROS domain, number of the robot. Five times a second it wants 0.2 m/s in the direction
of x. With topic and type as further arguments, it is a node that sends something wrong.
"""

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
from cyclonedds.idl.types import float32
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from cyclonedds.util import duration

topic, kind = sys.argv[3:] or ('cmd_cart_vel', 'Point32')
name = f'geometry_msgs::msg::dds_::{kind}_'  # as ROS names a message in DDS
Message = make_idl_struct(kind, name, dict.fromkeys('xyz', float32))

participant = DomainParticipant(int(sys.argv[1]))
velocities = DataWriter(
    participant,
    Topic(participant, f'rt/tb3_{sys.argv[2]}/{topic}', Message),
    Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(1)),
)
while True:
    velocities.write(Message(0.2, 0.0, 0.0))
    time.sleep(0.2)
