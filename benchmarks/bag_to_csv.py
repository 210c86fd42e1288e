"""Print how long `bag_to_csv` takes for a bag of a fleet, and how much memory.

python benchmarks/bag_to_csv.py [--nb-robots 8] [--messages 20000] [--quick]
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
TYPES = STORE.types
START_NS = 1_700_000_000_000_000_000
SETCMAS = Path(sys.executable).parent / 'setcmas'


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument('--nb-robots', type=int, default=8)
    parser.add_argument('--messages', type=int, default=20_000)
    parser.add_argument('--repeat', type=int, default=5)
    parser.add_argument('--quick', action='store_true', help='a small bag, once')
    args = parser.parse_args()
    if args.quick:
        args.messages, args.repeat = 500, 1
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / 'bag'
        count = write_bag(bag, args.nb_robots, args.messages)
        megabytes = sum(file.stat().st_size for file in bag.iterdir()) / 1e6
        durations = sorted(timed(bag) for _ in range(args.repeat))
    print(f'{count:,} messages of {args.nb_robots} robots, {megabytes:.0f} MB:')
    print(
        f'fastest {durations[0]:.2f} s, median {durations[len(durations) // 2]:.2f} s, start of '
        'the interpreter included'
    )
    largest = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e3
    print(f'largest process {largest:.0f} MB')


def timed(bag: Path, setcmas: Path = SETCMAS) -> float:
    """Return how long the command takes, start of the interpreter included, in s."""
    start = time.perf_counter()
    subprocess.run([setcmas, 'bag_to_csv', bag], check=True, capture_output=True)
    return time.perf_counter() - start


def write_bag(path: Path, nb_robots: int, nb_messages: int) -> int:
    """Write what a run with this fleet publishes; the numbers have all their digits."""
    chance = np.random.default_rng(1)
    makers = {
        'odom': odometry,
        'pose': pose_stamped,
        'marker': marker,
        'cmd_cart_vel': cmd_cart_vel,
        'cmd_vel': cmd_vel,
    }
    count = step = 0
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections: dict[str, Any] = {}
        while count < nb_messages:
            for robot in range(1, nb_robots + 1):
                for name, make in makers.items():
                    if name.startswith('cmd') and step % 2:
                        continue
                    topic = f'/tb3_{robot}/{name}'
                    time_ns = START_NS + step * 10**8 + robot * 10**5
                    message = make(robot, time_ns, chance)
                    msgtype = message.__msgtype__
                    if topic not in connections:
                        connections[topic] = writer.add_connection(topic, msgtype, typestore=STORE)
                    data = STORE.serialize_cdr(message, msgtype)
                    writer.write(connections[topic], time_ns, data)
                    count += 1
            step += 1
            if step % 10 == 0:
                writer.storage.close_chunk()
    return count


def header(time_ns: int) -> Any:
    stamp = TYPES['builtin_interfaces/msg/Time'](*divmod(time_ns, 10**9))
    return TYPES['std_msgs/msg/Header'](stamp, 'world')


def vector(x: float, y: float, z: float, name: str = 'Vector3') -> Any:
    return TYPES[f'geometry_msgs/msg/{name}'](float(x), float(y), float(z))


def pose(chance: np.random.Generator) -> Any:
    angle = chance.uniform(-1.5, 1.5)
    turn = TYPES['geometry_msgs/msg/Quaternion'](
        0.0, 0.0, float(np.sin(angle)), float(np.cos(angle))
    )
    return TYPES['geometry_msgs/msg/Pose'](vector(*chance.normal(size=2), 0, 'Point'), turn)


def twist(chance: np.random.Generator) -> Any:
    return TYPES['geometry_msgs/msg/Twist'](
        vector(chance.normal(), 0, 0), vector(0, 0, chance.normal())
    )


def odometry(robot: int, time_ns: int, chance: np.random.Generator) -> Any:
    return TYPES['nav_msgs/msg/Odometry'](
        header(time_ns),
        f'tb3_{robot}',
        TYPES['geometry_msgs/msg/PoseWithCovariance'](pose(chance), np.zeros(36)),
        TYPES['geometry_msgs/msg/TwistWithCovariance'](twist(chance), np.zeros(36)),
    )


def pose_stamped(_: int, time_ns: int, chance: np.random.Generator) -> Any:
    return TYPES['geometry_msgs/msg/PoseStamped'](header(time_ns), pose(chance))


def marker(robot: int, time_ns: int, chance: np.random.Generator) -> Any:
    nothing = np.zeros(0, np.uint8)
    return TYPES['visualization_msgs/msg/Marker'](
        header(time_ns),
        'robot',
        robot,
        1,
        0,
        pose(chance),
        vector(0.3, 0.3, 0.3),
        TYPES['std_msgs/msg/ColorRGBA'](1.0, 0.91, 0.31, 1.0),
        TYPES['builtin_interfaces/msg/Duration'](0, 0),
        False,
        [],
        [],
        '',
        TYPES['sensor_msgs/msg/CompressedImage'](header(0), '', nothing),
        [],
        '',
        '',
        TYPES['visualization_msgs/msg/MeshFile']('', nothing),
        False,
    )


def cmd_cart_vel(_: int, __: int, chance: np.random.Generator) -> Any:
    return vector(*chance.normal(size=2), 0, 'Point32')


def cmd_vel(_: int, time_ns: int, chance: np.random.Generator) -> Any:
    return TYPES['geometry_msgs/msg/TwistStamped'](header(time_ns), twist(chance))


if __name__ == '__main__':
    main()
