import csv

import numpy as np
import pytest

from setcmas_tools.tables import topic_table as csv_table
from setcmas_tools.tables.columns import LONGEST_ARRAY
from setcmas_tools.tables.flatten import flattener
from setcmas_tools.tables.topic_table import CsvTable


@pytest.fixture
def write(store, tmp_path):
    """Write messages of one type, one each second, and read the file back."""

    def write(messages):
        path = tmp_path / 'topic.csv'
        table = CsvTable(path, flattener(store, messages[0].__msgtype__))
        for second, message in enumerate(messages):
            table.add(second * 10**9, message)
        table.finish()
        with path.open(newline='') as file:
            rows = list(csv.reader(file))
        assert {len(row) for row in rows} == {len(rows[0])}
        assert [path.name] == [other.name for other in tmp_path.iterdir()]
        return [dict(zip(rows[0], row, strict=True)) for row in rows[1:]]

    return write


def marker(make, nb_points):
    points = [make('geometry_msgs/msg/Point', {'x': float(i)}) for i in range(nb_points)]
    return make('visualization_msgs/msg/Marker', {'points': points, 'text': 'a,"b"\nc'})


def test_times_and_messages(write, make):
    rows = write([make('std_msgs/msg/UInt16', {'data': i}) for i in range(3)])

    assert rows[1] == {'t': '1.000000000', 'data': '1'}


@pytest.mark.parametrize('rows_in_memory', [1, 3, 2000])
def test_rows_of_a_growing_array_have_all_columns(write, make, monkeypatch, rows_in_memory):
    monkeypatch.setattr(csv_table, '_ROWS_IN_MEMORY', rows_in_memory)
    rows = write([marker(make, nb) for nb in (0, 2, 2, 1, 3, 0)])

    assert [row['points[1].x'] for row in rows] == ['', '1.0', '1.0', '', '1.0', '']
    assert [row['points[2].z'] for row in rows] == ['', '', '', '', '0.0', '']
    assert {row['text'] for row in rows} == {'a,"b"\nc'}
    assert {row['yaw'] for row in rows} == {'0.0'}
    assert list(rows[0])[-1] == 'yaw'


def test_rows_of_arrays_in_arrays_have_all_columns(write, make):
    def array(*sizes):
        markers = [marker(make, size) for size in sizes]
        return make('visualization_msgs/msg/MarkerArray', {'markers': markers})

    rows = write([array(1, 0), array(), array(0, 2, 1)])

    assert [row['markers[0].points[0].x'] for row in rows] == ['0.0', '', '']
    assert [row['markers[1].points[1].x'] for row in rows] == ['', '', '1.0']
    assert [row['markers[1].text'] for row in rows] == ['a,"b"\nc', '', 'a,"b"\nc']
    assert [row['markers[2].points[0].x'] for row in rows] == ['', '', '0.0']


def test_arrays_that_are_sometimes_too_long(write, make):
    sizes = (2, LONGEST_ARRAY + 1, 1)
    rows = write(
        [make('sensor_msgs/msg/Image', {'data': np.ones(size, np.uint8)}) for size in sizes]
    )

    assert [row['data[1]'] for row in rows] == ['1', '', '']
    assert [row['data.length'] for row in rows] == ['', str(LONGEST_ARRAY + 1), '']


def test_cells_longer_than_the_csv_module_expects(write, make):
    rows = write([make('lab_msgs/msg/Reading', {'name': 'x' * 200_000, 'values': v})
                  for v in (np.ones(1), np.ones(2))])  # fmt: skip

    assert [row['values[1]'] for row in rows] == ['', '1.0']
    assert len(rows[0]['name']) == 200_000
