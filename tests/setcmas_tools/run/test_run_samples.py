from types import SimpleNamespace

import numpy as np
import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.fleet_motion import fleet_table
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_samples import CommunicationSamples, names_here
from setcmas_tools.run.run_tables import RunTables, read_tables, write_tables


@pytest.mark.parametrize(
    ('pattern', 'found', 'here'),
    [
        ('/{name}/odom', ['/robot7/odom', '/robot7/cmd_vel'], ['/tb3_7/odom', '/tb3_7/cmd_vel']),
        (
            '/{name}/odom',
            ['/zoe/odom', '/adam/odom', '/clock'],
            ['/tb3_2/odom', '/tb3_1/odom', '/clock'],
        ),
        ('/{name}/odom', ['/a1/odom', '/b1/odom'], ['/tb3_1/odom', '/tb3_2/odom']),
        ('/{name}/odom', ['/r0/odom', '/r1/odom'], ['/tb3_1/odom', '/tb3_2/odom']),
        (
            '/fleet/{name}/pose',
            ['/fleet/r3/pose', '/fleet/r3/cmd_vel'],
            ['/tb3_3/odom', '/tb3_3/cmd_vel'],
        ),
        ('/{name}/truth', ['/tb3_1/truth', '/tb3_1/odom'], ['/tb3_1/odom', '']),
        ('/{name}/odom', ['/tb3_1/odom', '/mocap/tb3_1/odom'], ['/tb3_1/odom', '']),
    ],
)
def test_names_of_other_robots(pattern, found, here):
    assert names_here(found, pattern) == dict(zip(found, here, strict=True))


@pytest.mark.parametrize(
    ('pattern', 'message'),
    [
        ('/robot1/odom', r'has no {name} for the name of a robot; an example is /{name}/odom'),
        (
            '/{name}/pose',
            r'no topic /{name}/pose; its topics are /clock, /robot1/odom',
        ),
    ],
)
def test_a_pattern_that_finds_no_robot(pattern, message):
    with pytest.raises(SetcmasError, match=message):
        names_here(['/robot1/odom', '/clock'], pattern)


def test_a_bag_of_robots_with_other_names(tmp_path, write_bag, make):
    messages = []
    for i in range(20):
        for robot in (1, 2):
            fields = {
                'pose.pose.position.x': float(10 * robot + i),
                'pose.pose.orientation.w': 1.0,
            }
            messages.append((f'/robot{robot}/odom', i / 10, make('nav_msgs/msg/Odometry', fields)))
            command = make('geometry_msgs/msg/Twist', {'linear.x': 0.25})
            if i >= 5:
                messages.append((f'/robot{robot}/cmd_vel', i / 10, command))
    bag = write_bag(tmp_path / 'bag', messages)

    run = Run.load(bag, odometry_topic='/{name}/odom')

    assert run.table.robots == [1, 2]
    assert run['tb3_2'].x[:3].tolist() == [20.0, 21.0, 22.0]
    assert run.table.t[0] == -0.5  # t = 0 is the first command
    with pytest.raises(SetcmasError, match='--odometry-topic names other topics'):
        Run.load(bag)
    run.save(tmp_path / 'run')
    with pytest.raises(SetcmasError, match='--odometry-topic is for bags'):
        Run.load(tmp_path / 'run', odometry_topic='/{name}/odom')


def test_messages_have_the_time_at_which_they_were_sent(tmp_path, write_bag, make):
    def message(label, offset, *data):
        dimension = make('std_msgs/msg/MultiArrayDimension', {'label': label, 'size': 1})
        layout = {'layout.dim': [dimension], 'layout.data_offset': offset}
        return make('std_msgs/msg/Float64MultiArray', layout | {'data': np.array(data)})

    odometry = make('nav_msgs/msg/Odometry', {'pose.pose.orientation.w': 1.0})
    command = make('geometry_msgs/msg/TwistStamped', {})
    bag = write_bag(
        tmp_path / 'bag',
        [
            ('/tb3_1/odom', 0.9, odometry),
            ('/tb3_1/cmd_vel', 1.0, command),
            ('/tb3_1/message', 1.9, message('x', 1, 0.0, 5.0)),  # recorded late
            ('/tb3_1/message', 1.9, message('x', 1, 0.8, 7.0)),
            ('/tb3_1/message', 2.2, message('', 0, 0.2, 5.0)),  # of another program
            ('/tb3_1/message', 5.0, message('', 1, 0.2, 6.0)),  # t has started anew
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


def test_of_messages_with_one_time_the_last_counts(tmp_path):
    samples = CommunicationSamples()
    for number in range(8):  # as `ros2 topic pub` repeats a message
        layout = SimpleNamespace(dim=[SimpleNamespace(label='', size=2, stride=2)], data_offset=1)
        message = SimpleNamespace(layout=layout, data=np.array([0.0, number, -number]))
        samples.take_message(1, number * 10**8, message)
    messages = samples.messages()
    assert [message.t for message in messages] == [0.0, pytest.approx(0.5), 0.6, 0.7]

    fleet = fleet_table([[0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    write_tables(RunTables(fleet, messages=messages), tmp_path)
    read = read_tables(tmp_path / 'fleet.csv').messages
    assert [message.value.tolist() for message in read] == [m.value.tolist() for m in messages]
