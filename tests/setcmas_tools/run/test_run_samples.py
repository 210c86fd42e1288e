import math

import pytest
from bag_contents import damage, only_file, write_compressed
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from setcmas_tools.measures.identification import recorded_commands
from setcmas_tools.run.run import Run


def test_messages_have_the_time_at_which_they_were_sent(tmp_path, write_bag, make):
    def message(data):
        return make('std_msgs/msg/String', {'data': data})

    odometry = make('nav_msgs/msg/Odometry', {'pose.pose.orientation.w': 1.0})
    command = make('geometry_msgs/msg/TwistStamped', {})
    bag = write_bag(
        tmp_path / 'bag',
        [
            ('/tb3_1/odom', 0.9, odometry),
            ('/tb3_1/cmd_vel', 1.0, command),
            ('/tb3_1/message', 1.9, message('{"t": 0.0, "value": {"x": 5.0}}')),  # recorded late
            ('/tb3_1/message', 1.9, message('{"t": 0.8, "value": {"x": 7.0}}')),
            ('/tb3_1/message', 2.2, message('5.0')),  # of another program
            ('/tb3_1/message', 5.0, message('{"t": 0.2, "value": 6.0}')),  # t has started anew
            ('/tb3_1/odom', 5.1, odometry),
        ],
    )
    run = Run.load(bag)

    assert run.messages == [
        (0.0, 1, {'x': 5.0}),
        (0.8, 1, {'x': 7.0}),
        (pytest.approx(4.0), 1, 6.0),
    ]
    assert run.record is None


def test_damage_of_a_bag_is_told_once_whatever_is_read_of_it_and_so_are_unusable_poses(
    tmp_path, store, make
):
    """It is read three times: for its first command, for its tables, and to identify robots."""
    nan = make('nav_msgs/msg/Odometry', {'pose.pose.position.x': math.nan})
    messages = [('/tb3_1/odom', 0, nan)]
    for i in range(8):
        messages += [(f'/tb3_{i % 2 + 1}/cmd_vel', 0, make('geometry_msgs/msg/TwistStamped'))]
        messages += [('/tb3_1/odom', 0, make('nav_msgs/msg/Odometry'))]
    (tmp_path / 'bag').mkdir()
    for name, part in (('a', messages[:9]), ('b', messages[9:])):
        write_compressed(
            tmp_path / name, store, part, CompressionMode.STORAGE, StoragePlugin.MCAP, (3,)
        )
        file = only_file(tmp_path / name, '*.mcap').rename(tmp_path / 'bag' / f'{name}.mcap')
        damage(file, 1)

    loaded, identified = [], []
    run = Run.load(tmp_path, loaded.append)
    recorded_commands(run, identified.append)

    damaged, unusable = loaded
    assert damaged.startswith(f"'{run.bag}' is damaged (")
    assert damaged.endswith('): later messages are missing')
    assert unusable.endswith('poses cannot be used: NaN, infinite, or a zero quaternion')
    assert identified == [damaged]
