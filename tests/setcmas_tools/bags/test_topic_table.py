import csv
import math

import numpy as np
import pytest
from rosbags.typesys import get_types_from_msg

from setcmas_tools.bags import topic_table
from setcmas_tools.bags.topic_table import LONGEST_ARRAY, TopicTable


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


@pytest.mark.parametrize('buffered', [1, 1_000_000])
def test_rows_of_a_growing_array_have_all_columns(write, make, monkeypatch, buffered):
    monkeypatch.setattr(topic_table, '_BUFFERED', buffered)
    rows = write([marker(make, nb) for nb in (0, 2, 2, 1, 3, 0)])

    assert [row['points[1].x'] for row in rows] == ['', '1.0', '1.0', '', '1.0', '']
    assert [row['points[2].z'] for row in rows] == ['', '', '', '', '0.0', '']
    assert {row['text'] for row in rows} == {'a,"b"\nc'}
    assert {row['yaw'] for row in rows} == {'0.0'}
    assert list(rows[0])[-1] == 'yaw'


def test_cells_longer_than_the_csv_module_expects(write, make):
    rows = write([make('lab_msgs/msg/Reading', {'name': 'x' * 200_000, 'values': v})
                  for v in (np.ones(1), np.ones(2))])  # fmt: skip

    assert [row['values[1]'] for row in rows] == ['', '1.0']
    assert len(rows[0]['name']) == 200_000
