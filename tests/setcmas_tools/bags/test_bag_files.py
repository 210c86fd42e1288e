"""Whatever happens to a file, a bag is read as far as it goes, or refused in one line."""

import shutil
import sqlite3

import pytest
from bag_contents import only_file, read, write_compressed
from mcap.writer import IndexType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from setcmas_simu.errors import SetcmasError

POINT = 'geometry_msgs/msg/Point32'


def test_mcap_cut_anywhere_gives_all_complete_chunks(tmp_path, write_bag, points):
    whole = only_file(write_bag(tmp_path / 'bag', points), '*.mcap').read_bytes()
    counts = []
    for size in range(100, len(whole), 97):
        path = tmp_path / 'cut.mcap'
        path.write_bytes(whole[:size])
        try:
            x, notices = read(path)
        except SetcmasError as error:
            x, notices = [], [str(error)]
        assert x == list(range(len(x)))
        assert len(notices) == 1
        assert 'cut short' in notices[0]
        counts.append(len(x))

    assert counts == sorted(counts)
    assert set(counts) == {0, 40, 80, 120, 160, 200}


def test_a_cut_mcap_is_reported(tmp_path, write_bag, points):
    path = only_file(write_bag(tmp_path / 'bag', points), '*.mcap')
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])

    x, (notice,) = read(path)

    assert len(x) == 120
    assert notice == f"'{path}' was cut short: 120 messages up to 3.0 s were read"
    path.write_bytes(whole[:-20])
    assert read(path) == (
        list(range(200)),
        [f"'{path}' was cut short: 200 messages up to 5.0 s were read"],
    )


@pytest.mark.parametrize('has_index', [True, False])
def test_what_is_read_up_to_a_damaged_chunk_is_told(tmp_path, store, points, has_index):
    write_compressed(
        tmp_path / 'bag', store, points, CompressionMode.STORAGE, StoragePlugin.MCAP, (49, 99)
    )
    path = only_file(tmp_path / 'bag', '*.mcap')
    content = bytearray(path.read_bytes())
    zstd_magic = b'\x28\xb5\x2f\xfd'
    content[content.index(zstd_magic, content.index(zstd_magic) + 1)] ^= 0xFF
    path.write_bytes(content if has_index else content[:-20])

    x, (notice,) = read(path)

    assert x == list(range(50))
    assert f"'{path}' is damaged " in notice
    assert ('50 of 200 messages were' if has_index else '50 messages up to 0.0 s were') in notice


def write_chunks(path, store, points, order=range(200), **options):
    """Write small chunks as another library does, with the messages in an order."""
    with path.open('wb') as stream:
        writer = McapWriter(stream, chunk_size=1000, **options)
        writer.start(profile='ros2')
        schema = writer.register_schema(POINT, 'ros2msg', b'float32 x\nfloat32 y\nfloat32 z')
        channel = writer.register_channel('/points', 'cdr', schema)
        for i in order:
            writer.add_message(channel, i + 1, points_bytes(store, points[i]), i + 1)
        writer.finish()


def points_bytes(store, point):
    return bytes(store.serialize_cdr(point[2], POINT))


@pytest.mark.parametrize(
    'options', [{'index_types': IndexType.CHUNK}, {'use_chunking': False}], ids=str
)
def test_an_mcap_file_without_indices_is_read_whole(tmp_path, store, points, options):
    path = tmp_path / 'others.mcap'
    write_chunks(path, store, points, [i + 3 - 2 * (i % 4) for i in range(200)], **options)

    assert read(path) == (list(range(200)), [])


@pytest.mark.parametrize('plugin', [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
@pytest.mark.parametrize('mode', [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_compressed_bag(tmp_path, store, points, mode, plugin):
    write_compressed(tmp_path / 'bag', store, points, mode, plugin)

    assert read(tmp_path / 'bag') == (list(range(200)), [])


def test_a_split_bag_of_a_killed_recorder_is_read_in_the_order_of_time(
    tmp_path, write_bag, points
):
    folder = tmp_path / 'bag'
    folder.mkdir()
    for name, part in (('a_1', points[:120]), ('a_0', points[120:])):
        shutil.move(only_file(write_bag(tmp_path / name, part), '*.mcap'), folder)
    (folder / 'a_2.mcap').touch()

    x, (notice,) = read(folder)

    assert x == list(range(200))
    assert 'a_2.mcap' in notice


def split_bag(folder, write_bag, points):
    """Write a bag of two files, of which metadata.yaml lists the first; return the second."""
    write_bag(folder, points[:120])
    second = folder / 'second.mcap'
    shutil.copy(only_file(write_bag(folder.with_name('other'), points[120:]), '*.mcap'), second)
    return second


def test_files_that_the_metadata_does_not_list_are_read(tmp_path, write_bag, points):
    split_bag(tmp_path / 'bag', write_bag, points)

    assert read(tmp_path / 'bag') == (list(range(200)), [])


def test_files_that_are_missing_are_named(tmp_path, write_bag, points):
    second = split_bag(tmp_path / 'bag', write_bag, points)
    metadata = second.with_name('metadata.yaml')
    metadata.write_text(metadata.read_text().replace('- bag.mcap', '- bag.mcap\n  - second.mcap'))
    second.unlink()

    x, (notice,) = read(tmp_path / 'bag')

    assert x == list(range(120))
    assert notice.endswith("bag' lacks second.mcap, which its metadata.yaml lists")


def test_messages_in_a_journal_of_sqlite_are_told(tmp_path, write_bag, points):
    file = only_file(write_bag(tmp_path / 'bag', points, 'sqlite3'), '*.db3')
    with sqlite3.connect(file) as recorder:
        recorder.execute('PRAGMA journal_mode = WAL')
        recorder.execute(
            'INSERT INTO messages SELECT NULL, topic_id, timestamp, data FROM messages'
        )
        recorder.commit()

        for path in (file, file.parent):
            x, (notice,) = read(path)
            assert x == list(range(200))
            assert notice.startswith(f"messages in '{file}-wal' were not read; first run sqlite3 ")
    recorder.close()
    assert len(read(file)[0]) == 400
