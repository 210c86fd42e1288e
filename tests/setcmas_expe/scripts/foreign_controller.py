"""A control law of one robot by another maker: Cyclone DDS, without ROS.

Arguments: ROS domain, number of the robot. Five times a second it wants 0.2 m/s in the direction
of x.
"""

import sys
import time

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl.types import float32
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from foreign_robot import message  # sets Cyclone DDS up

Point32 = message('geometry_msgs/Point32', **dict.fromkeys('xyz', float32))


def main():
    participant = DomainParticipant(int(sys.argv[1]))
    velocities = DataWriter(
        participant,
        Topic(participant, f'rt/tb3_{sys.argv[2]}/cmd_cart_vel', Point32),
        Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(1)),
    )
    while True:
        velocities.write(Point32(0.2, 0.0, 0.0))
        time.sleep(0.2)


if __name__ == '__main__':
    main()
