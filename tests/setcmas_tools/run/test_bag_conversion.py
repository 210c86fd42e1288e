import csv
import math
import subprocess
import sys
from operator import itemgetter
from pathlib import Path

import pytest
from rosbags.rosbag2 import StoragePlugin, Writer

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.topic_table import TopicTable
from setcmas_tools.run.bag_conversion import convert, file_names
from setcmas_tools.run.run_samples import read_bag
from setcmas_tools.run.run_tables import read_fleet, stem_of_bag


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


@pytest.mark.parametrize('plugin', ['mcap', 'sqlite3'])
def test_a_file_for_each_topic_and_one_for_the_fleet(tmp_path, write_bag, run, plugin):
    report = convert(write_bag(tmp_path / 'bag', run, plugin))

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
    odometry_rows = rows_of(report.files[1])
    assert len(odometry_rows) == 40
    assert odometry_rows[12]['t'] == '-0.300000000'
    assert odometry_rows[12]['pose.pose.position.x'] == '112.0'
    assert rows_of(report.files[0])[0]['t'] == '0.000000000'
    assert sorted(path.name for path in report.folder.iterdir()) == sorted(
        [*(file.name for file in report.files), 'fleet.csv']
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

    assert read_bag(tmp_path / 'bag', lines.append).fleet.x.tolist() == [1.0]
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
    names = file_names(['/a/b', '/a_b', '/A_B', '/a/b_2', '/fleet', '/fleet_2', '/é?', '/'])

    assert names[0] == 'a_b.csv'
    assert names[4] == 'fleet_2.csv'
    assert len({name.lower() for name in [*names, 'fleet.csv']}) == 9


def test_two_types_on_one_topic(tmp_path, write_bag, make):
    messages = [
        ('/tb3_1/cmd_vel', 0, make('geometry_msgs/msg/Twist', {'linear.x': 1.0})),
        ('/tb3_1/cmd_vel', 1, make('geometry_msgs/msg/TwistStamped', {'twist.linear.x': 2.0})),
    ]
    report = convert(write_bag(tmp_path / 'bag', messages))

    assert [file.name for file in report.files] == ['tb3_1_cmd_vel.csv', 'tb3_1_cmd_vel_2.csv']
    assert rows_of(report.files[0])[0]['linear.x'] == '1.0'
    assert rows_of(report.files[1])[0]['twist.linear.x'] == '2.0'


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


def test_output_that_cannot_be_written(tmp_path, write_bag, points):
    bag = write_bag(tmp_path / 'bag', points)
    (tmp_path / 'taken').write_text('a file')

    with pytest.raises(SetcmasError, match='cannot be written'):
        convert(bag, tmp_path / 'taken')


def test_needs_neither_ros_nor_matplotlib():
    code = (
        'import sys; import setcmas_tools.run.bag_conversion; '
        'print([name for name in ("rclpy", "matplotlib", "tqdm") if name in sys.modules])'
    )
    output = subprocess.run([sys.executable, '-c', code], capture_output=True, check=True).stdout

    assert output.strip() == b'[]'


def test_bags_whose_names_differ_by_the_ending_have_folders_of_their_own(tmp_path):
    lab = tmp_path / 'lab.mcap'
    lab.touch()
    assert stem_of_bag(lab) == 'lab_'

    (tmp_path / 'lab.bag').touch()
    assert stem_of_bag(lab) == 'lab.mcap_'
