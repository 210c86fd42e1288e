"""A controller of robot 2 by another maker, in lockstep: Cyclone DDS, without ROS.

Argument: ROS domain. It drives robot 2 straight on at 0.2 m/s, and checks that each of its
commands moves the robot in its own step. Prints `exact` after 100 steps, and leaves.
"""

import json
import math
import os
import sys
import time

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl.types import float64, sequence, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from foreign_robot import message  # sets Cyclone DDS up

ROBOT, V, RATE_HZ, NB_STEPS = 2, 0.2, 10.0, 100
LATCHED = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)),
    Policy.Durability.TransientLocal,
    Policy.History.KeepLast(100),
)


String = message('std_msgs/String', data=str)
Dimension = message('std_msgs/MultiArrayDimension', label=str, size=uint32, stride=uint32)
Layout = message('std_msgs/MultiArrayLayout', dim=sequence[Dimension], data_offset=uint32)
Float64MultiArray = message('std_msgs/Float64MultiArray', layout=Layout, data=sequence[float64])


def messages(reader, kind):
    """Yield new messages, one by one, for ever."""
    while True:
        for one in reader.take(1):
            if isinstance(one, kind):  # not the end of a writer
                yield one
        time.sleep(0.001)


def main():
    participant = DomainParticipant(int(sys.argv[1]))

    def topic(name, kind):
        return Topic(participant, f'rt/{name}', kind)

    answers = DataWriter(participant, topic('lockstep', Float64MultiArray), LATCHED)
    fleet = DataReader(participant, topic('fleet', String), LATCHED)
    states = DataReader(participant, topic('lockstep_states', Float64MultiArray), LATCHED)

    announced = json.loads(next(messages(fleet, String)).data)
    assert announced['lockstep'] == {'robot_rate': RATE_HZ, 'nb_steps': None}

    def answer(stamp, leaves=0):
        command = [stamp, V, 0.0, 0.0, *[math.nan] * 5]  # its law has no velocity, nor a filter
        numbers = [2, 4711, os.getpid(), stamp, leaves, 1, ROBOT, *command]
        answers.write(Float64MultiArray(Layout([], 0), numbers))

    start = None
    for array in messages(states, Float64MultiArray):
        version, stamp, *numbers = array.data
        assert version == 2
        rows = {numbers[i]: numbers[i + 1 : i + 8] for i in range(0, len(numbers), 8)}
        x = rows[ROBOT][0]
        start = (stamp, x) if start is None else start
        step = round((stamp - start[0]) * 1e-9 * RATE_HZ)
        assert abs(x - start[1] - V * step / RATE_HZ) < 1e-9, (step, x)
        answer(stamp, leaves=int(step == NB_STEPS))
        if step == NB_STEPS:
            print('exact', flush=True)
            time.sleep(1.0)
            return


if __name__ == '__main__':
    main()
