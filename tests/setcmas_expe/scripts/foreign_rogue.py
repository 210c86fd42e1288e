"""A rogue by another maker: Cyclone DDS, without ROS. It tries all ways to drive robot 1.

Arguments: ROS domain; `guarded` to drive it past its guard, too. Publishes 50 times a second
until it is ended.
"""

import sys
import time

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl.types import array, float32, float64
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from foreign_robot import (  # sets Cyclone DDS up
    STEP_S,
    Header,
    Pose,
    Quaternion,
    Time,
    Twist,
    TwistStamped,
    Vector3,
    message,
)

RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(1))


Point32 = message('geometry_msgs/Point32', **dict.fromkeys('xyz', float32))
Bool = message('std_msgs/Bool', data=bool)
COVARIANCE = array[float64, 36]
PoseWithCovariance = message('geometry_msgs/PoseWithCovariance', pose=Pose, covariance=COVARIANCE)
TwistWithCovariance = message(
    'geometry_msgs/TwistWithCovariance', twist=Twist, covariance=COVARIANCE
)
Odometry = message(
    'nav_msgs/Odometry', header=Header, child_frame_id=str, pose=PoseWithCovariance,
    twist=TwistWithCovariance,
)  # fmt: skip


def main():
    participant = DomainParticipant(int(sys.argv[1]))

    def writer(topic, kind):
        return DataWriter(participant, Topic(participant, f'rt/{topic}', kind), RELIABLE)

    ahead = Twist(Vector3(0.2, 0.0, 0.0), Vector3(0.0, 0.0, 0.0))
    place = Pose(Vector3(3.0, 0.0, 0.0), Quaternion(0.0, 0.0, 1.0, 0.0))
    drives = [
        (writer('tb3_1/cmd_vel', TwistStamped), lambda header: TwistStamped(header, ahead)),
        (writer('tb3_1/cmd_vel_wanted', TwistStamped), lambda header: TwistStamped(header, ahead)),
        (writer('tb3_1/cmd_cart_vel', Point32), lambda _: Point32(0.2, 0.0, 0.0)),
        (
            writer('mocap/tb3_1/odom', Odometry),
            lambda header: Odometry(
                header,
                'tb3_1',
                PoseWithCovariance(place, [0.0] * 36),
                TwistWithCovariance(ahead, [0.0] * 36),
            ),
        ),
        (writer('paused', Bool), lambda _: Bool(False)),
        (writer('emergency_stopped', Bool), lambda _: Bool(False)),
    ]
    if 'guarded' in sys.argv:
        past = writer('tb3_1/cmd_vel_guarded', TwistStamped)
        drives.append((past, lambda header: TwistStamped(header, ahead)))
    print('drives', flush=True)
    while True:
        now = time.time()
        header = Header(Time(int(now), int(1e9 * (now % 1))), 'world')
        for one, make in drives:
            one.write(make(header))
        time.sleep(STEP_S)


if __name__ == '__main__':
    main()
