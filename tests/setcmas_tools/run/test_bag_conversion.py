import csv
import math
from operator import itemgetter
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_types_from_msg

from setcmas_tools.run import bag_conversion
from setcmas_tools.run.bag_conversion import LONGEST_ARRAY, TopicTable, convert, file_names
from setcmas_tools.run.run_samples import read_bag
from setcmas_tools.run.run_tables import read_fleet


def rows_of(path):
    with path.open(newline='') as file:
        return list(csv.DictReader(file))


def odometry(make, x, yaw=0.0, v=0.0):
    fields = {
        'pose.pose.position.x': x,
        'pose.pose.orientation.z': math.sin(yaw / 2),
        'pose.pose.orientation.w': math.cos(yaw / 2),
        'twist.twist.linear.x': v,
    }
    return make('nav_msgs/msg/Odometry', fields)


@pytest.fixture
def run(make):
    """Two robots: odometry from 0 s, the first command at 1.5 s."""
    messages = []
    for i in range(40):
        for robot in (1, 2):
            x = float(robot * 100 + i)
            messages.append((f'/tb3_{robot}/odom', i / 10, odometry(make, x, 0.5, 0.25)))
            if i >= 15:
                command = make('geometry_msgs/msg/TwistStamped', {'twist.linear.x': 0.25})
                messages.append((f'/tb3_{robot}/cmd_vel', i / 10, command))
    return messages


def test_a_file_for_each_topic_and_one_for_the_fleet(tmp_path, write_bag, run):
    report = convert(write_bag(tmp_path / 'bag', run))

    assert report.folder == tmp_path / 'csv'
    assert [file.name for file in report.files] == [
        'tb3_1_cmd_vel.csv',
        'tb3_1_odom.csv',
        'tb3_2_cmd_vel.csv',
        'tb3_2_odom.csv',
    ]
    assert report.fleet == tmp_path / 'csv' / 'fleet.csv'
    assert (report.messages, report.notices) == (130, [])
    assert report.duration == pytest.approx(3.9)
    assert str(report) == (
        f'130 messages of 4 topics, 3.9 s: 4 CSV files and fleet.csv in {report.folder}'
    )


def test_time_of_an_experiment_begins_at_its_start(tmp_path, write_bag, run, make):
    pauses = [
        ('/paused', at, make('std_msgs/msg/Bool', {'data': at != 2.5})) for at in (0, 2.5, 3)
    ]
    report = convert(write_bag(tmp_path / 'bag', sorted([*run, *pauses], key=itemgetter(1))))

    assert read_fleet(report.fleet).t[0] == -2.5
    assert [row['t'] for row in rows_of(report.files[0])] == [
        '-2.500000000',
        '0.000000000',
        '0.500000000',
    ]


def test_a_zero_quaternion_has_no_heading(tmp_path, write_bag, make):
    good, zero = odometry(make, 1.0, 0.5), make('nav_msgs/msg/Odometry', {})
    zero.pose.pose.orientation.w = 0.0
    messages = [('/tb3_1/odom', 0, good), ('/tb3_1/odom', 1, zero)]
    report = convert(write_bag(tmp_path / 'bag', messages))

    headings = read_fleet(tmp_path / 'csv' / 'fleet.csv').theta
    assert headings.tolist() == pytest.approx([0.5, math.nan], nan_ok=True)
    yaws = [row['yaw'] for row in rows_of(tmp_path / 'csv' / 'tb3_1_odom.csv')]
    assert yaws[1] == 'nan'
    unusable = 'robot 1: 1 of 2 poses cannot be used: NaN, infinite, or a zero quaternion'
    assert report.notices == [unusable]


def test_motion_capture_goes_before_wheel_odometry(tmp_path, write_bag, make):
    messages = [
        ('/mocap/tb3_1/odom', 0.1, odometry(make, 1.0)),
        ('/tb3_1/odom', 0.2, odometry(make, 2.0)),
        ('/tb3_2/odom', 0.3, odometry(make, 3.0)),
        ('/tb3_10/odom', 0.4, odometry(make, 4.0)),
        ('/prefix/tb3_3/odom', 0.5, odometry(make, 5.0)),
        ('/tb3_4/odom', 0.6, make('std_msgs/msg/String')),
    ]
    convert(write_bag(tmp_path / 'bag', messages))
    table = read_fleet(tmp_path / 'csv' / 'fleet.csv')

    assert table.robot.tolist() == [1, 2, 10]
    assert table.x.tolist() == [1.0, 3.0, 4.0]


def test_who_reads_a_bag_without_its_csv_files_is_told_what_cannot_be_decoded(
    tmp_path, store, make
):
    good, msgtype = odometry(make, 1.0), 'nav_msgs/msg/Odometry'
    with Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection('/tb3_1/odom', msgtype, typestore=store)
        writer.write(connection, 1, b'\x00\x01')
        writer.write(connection, 2, store.serialize_cdr(good, msgtype))
    lines = []

    assert read_bag(tmp_path / 'bag', lines.append).table.x.tolist() == [1.0]
    assert ['topic /tb3_1/odom: 1 of 2 messages are left out' in line for line in lines] == [True]


@pytest.mark.parametrize(
    ('bag', 'folder'), [('bag', 'csv'), ('lab', 'lab_csv'), ('bag/bag.mcap', 'bag/bag_csv')]
)
def test_default_folder(tmp_path, write_bag, points, monkeypatch, bag, folder):
    write_bag(tmp_path / Path(bag).parts[0], points)
    monkeypatch.chdir(tmp_path)

    assert convert(Path(bag)).folder == Path(folder)
    assert convert(tmp_path / bag).folder == tmp_path / folder


def test_file_names_do_not_collide():
    names = file_names(['/a/b', '/a/b', '/A_B', '/a/b_2', '/fleet', '/fleet_2', '/é?', '/'])

    assert names[0] == 'a_b.csv'
    assert names[4] == 'fleet_2.csv'
    assert len({name.lower() for name in [*names, 'fleet.csv']}) == 9


def test_an_interrupted_conversion_leaves_the_earlier_files(
    tmp_path, write_bag, points, monkeypatch
):
    bag = write_bag(tmp_path / 'bag', points)
    before = convert(bag).files[0].read_bytes()
    rows = iter(range(150))

    def add(self, *_):
        if next(rows, None) is None:
            raise KeyboardInterrupt

    monkeypatch.setattr(TopicTable, 'add', add)
    with pytest.raises(KeyboardInterrupt):
        convert(bag)

    assert [path.read_bytes() for path in (tmp_path / 'csv').iterdir()] == [before]


@pytest.fixture
def write(store, tmp_path):
    """Write messages of one type, one each second, and read the file back."""

    def write(messages):
        path = tmp_path / 'topic.csv'
        path.unlink(missing_ok=True)
        table = TopicTable(path, store)
        for second, message in enumerate(messages):
            table.add(second * 10**9, message)
        table.finish()
        with path.open(newline='', encoding='utf-8') as file:
            rows = list(csv.reader(file))
        assert {len(row) for row in rows} == {len(rows[0])}
        assert [path.name] == [other.name for other in tmp_path.iterdir()]
        return [dict(zip(rows[0], row, strict=True)) for row in rows[1:]]

    return write


@pytest.fixture
def flatten(write):
    """Return the columns of a message as a dictionary of text."""

    def flatten(message):
        (row,) = write([message])
        assert row.pop('t') == '0.000000000'
        return row

    return flatten


@pytest.mark.parametrize(
    ('msgtype', 'path'),
    [
        ('geometry_msgs/msg/Pose', 'orientation'),
        ('geometry_msgs/msg/PoseStamped', 'pose.orientation'),
        ('geometry_msgs/msg/PoseWithCovariance', 'pose.orientation'),
        ('geometry_msgs/msg/PoseWithCovarianceStamped', 'pose.pose.orientation'),
        ('geometry_msgs/msg/TransformStamped', 'transform.rotation'),
        ('visualization_msgs/msg/Marker', 'pose.orientation'),
    ],
)
def test_yaw_is_the_last_column_of_poses(make, flatten, msgtype, path):
    columns = flatten(make(msgtype, {f'{path}.z': 1.0}))

    assert list(columns)[-1] == 'yaw'
    assert float(columns['yaw']) == pytest.approx(math.pi)


@pytest.mark.parametrize(
    'text', ['plain', 'a,b', 'say "hi"', 'two\nlines', 'two\r\nlines', 'two\rlines', '', 'é ω 火']
)
def test_strings_survive_a_csv_reader_but_for_carriage_returns(make, flatten, text):
    read = flatten(make('std_msgs/msg/String', {'data': text}))['data']

    assert read.splitlines() == text.splitlines()


def test_numbers_of_every_kind(make, flatten):
    assert flatten(make('std_msgs/msg/Bool', {'data': True})) == {'data': '1'}
    assert flatten(make('std_msgs/msg/Int64', {'data': -(2**62)})) == {'data': str(-(2**62))}
    assert flatten(make('std_msgs/msg/Float32', {'data': float(np.float32(0.1))})) == {
        'data': '0.1'
    }
    assert flatten(make('std_msgs/msg/Float64', {'data': 0.1 + 0.2})) == {
        'data': '0.30000000000000004'
    }
    assert flatten(make('std_msgs/msg/Float64', {'data': math.nan})) == {'data': 'nan'}
    assert flatten(make('std_msgs/msg/Empty')) == {}


def test_arrays_of_messages_with_arrays(make, flatten):
    samples = [
        make('lab_msgs/msg/Sample', {'counts': np.array([1, 2], np.int32), 'labels': ['a']}),
        make('lab_msgs/msg/Sample', {'stamp.sec': 5}),
    ]
    columns = flatten(make('lab_msgs/msg/Reading', {'name': 'x', 'samples': samples}))

    assert columns == {
        'name': 'x',
        'samples[0].stamp': '0.000000000',
        'samples[0].counts[0]': '1',
        'samples[0].counts[1]': '2',
        'samples[0].labels[0]': 'a',
        'samples[1].stamp': '5.000000000',
        'samples[1].counts[0]': '0',
        'samples[1].counts[1]': '0',
    }


@pytest.mark.parametrize('length', [LONGEST_ARRAY, LONGEST_ARRAY + 1])
def test_very_long_arrays_become_their_length(make, flatten, length):
    columns = flatten(make('sensor_msgs/msg/Image', {'data': np.zeros(length, np.uint8)}))

    is_long = length > LONGEST_ARRAY
    assert columns.get('data.length') == (str(length) if is_long else None)
    assert ('data[0]' in columns) != is_long


def test_field_names_that_python_reserves(store, make, flatten):
    store.register(get_types_from_msg('float64 from\nfloat64 class', 'lab_msgs/msg/Range'))

    columns = flatten(make('lab_msgs/msg/Range', {'from_': 1.0, 'class_': 2.0}))

    assert columns == {'from': '1.0', 'class': '2.0'}


def marker(make, nb_points):
    points = [make('geometry_msgs/msg/Point', {'x': float(i)}) for i in range(nb_points)]
    fields = {'points': points, 'text': 'a,"b"\nc', 'pose.orientation.w': 1.0}
    return make('visualization_msgs/msg/Marker', fields)


@pytest.mark.parametrize('buffered', [1, 100])
def test_rows_of_a_growing_array_have_all_columns(write, make, monkeypatch, buffered):
    monkeypatch.setattr(bag_conversion, '_BUFFERED', buffered)
    rows = write([marker(make, nb) for nb in (0, 2, 2, 1, 3, 0)])

    assert [row['points[1].x'] for row in rows] == ['', '1.0', '1.0', '', '1.0', '']
    assert [row['points[2].z'] for row in rows] == ['', '', '', '', '0.0', '']
    assert {row['text'] for row in rows} == {'a,"b"\nc'}
    assert {row['yaw'] for row in rows} == {'0.0'}


def test_cells_longer_than_the_csv_module_expects(write, make):
    rows = write([make('lab_msgs/msg/Reading', {'name': 'x' * 200_000, 'values': v})
                  for v in (np.ones(1), np.ones(2))])  # fmt: skip

    assert [row['values[1]'] for row in rows] == ['', '1.0']
    assert len(rows[0]['name']) == 200_000
