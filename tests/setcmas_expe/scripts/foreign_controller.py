"""A controller of robot 2 by another maker, in lockstep: Cyclone DDS, without ROS.

Argument: ROS domain. It drives robot 2 straight on at 0.2 m/s, and checks that each of its
commands moves the robot in its own step. Prints `exact` after 100 steps, and leaves.
"""

import json
import os
import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import int64, sequence, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from foreign_robot import Header, TwistStamped, Vector3  # sets Cyclone DDS up
from foreign_rogue import Odometry, Twist

ROBOT, V, RATE_HZ, NB_STEPS = 2, 0.2, 10.0, 100
SILENCE_S = 1.0
LATCHED = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)),
    Policy.Durability.TransientLocal,
    Policy.History.KeepLast(100),
)
RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(100))


@dataclass
class String(IdlStruct, typename='std_msgs::msg::dds_::String_'):
    data: str


@dataclass
class Dimension(IdlStruct, typename='std_msgs::msg::dds_::MultiArrayDimension_'):
    label: str
    size: uint32
    stride: uint32


@dataclass
class Layout(IdlStruct, typename='std_msgs::msg::dds_::MultiArrayLayout_'):
    dim: sequence[Dimension]
    data_offset: uint32


@dataclass
class Int64MultiArray(IdlStruct, typename='std_msgs::msg::dds_::Int64MultiArray_'):
    layout: Layout
    data: sequence[int64]


def messages(reader, kind, after_silence=lambda: None):
    """Yield new messages, one by one, for ever; after a second without any, call a function."""
    last = time.monotonic()
    while True:
        for message in reader.take(1):
            if isinstance(message, kind):  # not the end of a writer
                yield message
                last = time.monotonic()
        if time.monotonic() > last + SILENCE_S:
            after_silence()
            last = time.monotonic()
        time.sleep(0.001)


def main():
    participant = DomainParticipant(int(sys.argv[1]))

    def topic(name, kind):
        return Topic(participant, f'rt/{name}', kind)

    answers = DataWriter(participant, topic('lockstep', Int64MultiArray), LATCHED)
    commands = DataWriter(participant, topic(f'tb3_{ROBOT}/cmd_vel', TwistStamped), RELIABLE)
    fleet = DataReader(participant, topic('fleet', String), LATCHED)
    odometry = DataReader(participant, topic(f'tb3_{ROBOT}/odom', Odometry), LATCHED)

    announced = json.loads(next(messages(fleet, String)).data)
    assert announced['version'] == 1
    assert announced['time'] == {'type': 'Lockstep', 'robot_rate': RATE_HZ, 'nb_steps': None}

    def answer(stamp, commanded, leaves=0):
        numbers = [1, 4711, os.getpid(), stamp, commanded, leaves, ROBOT]
        answers.write(Int64MultiArray(Layout([], 0), numbers))

    def command():
        if start is None:
            return
        ahead = Twist(Vector3(V, 0.0, 0.0), Vector3(0.0, 0.0, 0.0))
        commands.write(TwistStamped(Header(stamp, 'world'), ahead))

    start = None
    for state in messages(odometry, Odometry, after_silence=command):
        stamp = state.header.stamp
        x = state.pose.pose.position.x
        nanoseconds = stamp.sec * 10**9 + stamp.nanosec
        start = (nanoseconds, x) if start is None else start
        step = round((nanoseconds - start[0]) * 1e-9 * RATE_HZ)
        assert abs(x - start[1] - V * step / RATE_HZ) < 1e-9, (step, x)
        if step == NB_STEPS:
            print('exact', flush=True)
            answer(-1, -1, leaves=1)
            time.sleep(1.0)
            return
        command()
        answer(nanoseconds, nanoseconds)


if __name__ == '__main__':
    main()
