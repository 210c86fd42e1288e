import random
import shutil

import pytest
import zstandard
from bag_contents import only_file, read, write_compressed
from rosbags.rosbag2 import CompressionMode, StoragePlugin


@pytest.mark.parametrize('plugin', [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
@pytest.mark.parametrize('form', ['folder', 'without metadata', 'lone file'])
@pytest.mark.parametrize('mode', [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_compressed_bag(tmp_path, store, points, mode, form, plugin):
    folder = tmp_path / 'bag'
    write_compressed(folder, store, points, mode, plugin)
    if form == 'without metadata':
        (folder / 'metadata.yaml').unlink()

    path = only_file(folder, 'bag.[md]*') if form == 'lone file' else folder
    assert read(path) == (list(range(200)), [])


def split(folder, write_bag, points, ends):
    """Write a bag in several files; return them."""
    for i, (begin, end) in enumerate(zip([0, *ends], [*ends, len(points)], strict=True)):
        part = write_bag(folder.parent / f'{folder.name}_{i}', points[begin:end])
        folder.mkdir(exist_ok=True)
        shutil.move(only_file(part, '*.mcap'), folder)
    return sorted(folder.iterdir())


def packed(file):
    target = file.with_name(f'{file.name}.zstd')
    target.write_bytes(zstandard.compress(file.read_bytes()))
    return target


def test_a_recorder_killed_while_it_compresses_leaves_both_kinds_of_files(
    tmp_path, write_bag, points
):
    first, second, _ = split(tmp_path / 'bag', write_bag, points, [80, 150])
    packed(first)
    first.unlink()
    half = packed(second)
    half.write_bytes(half.read_bytes()[: half.stat().st_size // 2])

    assert read(tmp_path / 'bag') == (list(range(200)), [])


def test_a_cut_compressed_file_is_read_as_far_as_it_goes(tmp_path, write_bag, make):
    chance = random.Random(1)  # numbers that compress badly: zstd unpacks 128 kB at once
    messages = [
        ('/p', i / 40, make('geometry_msgs/msg/Point32', {'x': float(i), 'y': chance.random()}))
        for i in range(8000)
    ]
    file = packed(only_file(write_bag(tmp_path / 'bag', messages), '*.mcap'))
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])

    x, (notice,) = read(file)

    assert x == list(range(len(x)))
    assert 0 < len(x) < 8000
    assert f"'{file}' was cut short: {len(x):,} messages up to " in notice


def test_the_files_of_a_split_bag_are_read_in_the_order_of_time(tmp_path, write_bag, points):
    folder = tmp_path / 'bag'
    folder.mkdir()
    for name, part in (('a_1', points[:120]), ('a_0', points[120:])):
        shutil.move(only_file(write_bag(tmp_path / name, part), '*.mcap'), folder)

    assert read(folder) == (list(range(200)), [])


def test_messages_that_metadata_lists_and_that_are_gone_are_told(tmp_path, write_bag, points):
    folder = write_bag(tmp_path / 'bag', points)
    shutil.move(write_bag(tmp_path / 'other', points[:150]) / 'other.mcap', folder / 'bag.mcap')

    assert read(folder) == (
        list(range(150)),
        [f"'{folder}' has 150 of the 200 messages that its metadata.yaml lists"],
    )


def test_a_broken_file_of_a_split_bag_does_not_hide_the_others(tmp_path, write_bag, points):
    folder = write_bag(tmp_path / 'bag', points)
    (folder / 'bag_1.mcap').touch()

    x, notices = read(folder)

    assert x == list(range(200))
    assert len(notices) == 1
    assert 'bag_1.mcap' in notices[0]
