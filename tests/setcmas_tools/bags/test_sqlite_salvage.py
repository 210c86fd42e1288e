import shutil
import sqlite3

import numpy as np
import pytest
from bag_contents import only_file, read

from setcmas_tools.bags.reader import open_bag


def test_cut_database_gives_the_rows_before_the_cut(tmp_path, write_bag, make):
    message = make('sensor_msgs/msg/LaserScan', {'ranges': np.ones(500, np.float32)})
    bag = write_bag(tmp_path / 'bag', [('/scan', i, message) for i in range(400)], 'sqlite3')
    file = only_file(bag, '*.db3')
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2])

    with open_bag(bag) as opened:
        times = [time_ns for _, time_ns, _ in opened.messages()]
        assert 100 < len(times) < 400
        assert times == sorted(times)
        (notice,) = opened.notices
    assert 'is damaged' in notice


@pytest.mark.parametrize('name', ['lab #1.db3', '50%25.db3', 'what?.db3', "it's.db3"])
def test_database_with_a_name_that_addresses_reserve(tmp_path, write_bag, points, name):
    file = only_file(write_bag(tmp_path / 'bag', points, 'sqlite3'), '*.db3')
    moved = file.rename(tmp_path / name)

    assert read(moved) == (list(range(200)), [])


def test_database_of_a_killed_recorder_with_a_write_ahead_log(tmp_path, write_bag, points):
    file = only_file(write_bag(tmp_path / 'bag', points, 'sqlite3'), '*.db3')
    database = sqlite3.connect(file)
    database.execute('PRAGMA journal_mode=WAL')
    database.execute('DELETE FROM messages WHERE id > 150')
    database.commit()
    killed = tmp_path / 'killed'
    killed.mkdir()
    for part in file.parent.glob('*.db3*'):
        shutil.copy(part, killed)
    database.close()

    assert read(killed) == (list(range(150)), [])
