"""A small bag takes little memory and time, or is refused in one line."""

import struct
import zlib

import pytest
from mcap.stream_reader import lz4, zstandard
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags import bag_limits
from setcmas_tools.bags.bag import open_bag
from setcmas_tools.bags.type_limits import TooLargeError, TypeLimits
from setcmas_tools.run.bag_conversion import convert

BOMBS = {
    'zstd': lambda size: zstandard.ZstdCompressor(write_content_size=False).compress(bytes(size)),
    'lz4': lambda size: lz4.compress(bytes(size)),
}


@pytest.fixture
def bomb(tmp_path):
    """A function that writes an mcap file with chunks of zeros."""

    def write(kind, size, count=1, claimed=None):
        data = BOMBS[kind](size)
        body = struct.pack('<QQQII', 1, 2, claimed or size, zlib.crc32(b''), len(kind))
        body += kind.encode() + struct.pack('<Q', len(data)) + data
        chunk = struct.pack('<BQ', 6, len(body)) + body
        header = struct.pack('<I', 4) + b'ros2' + struct.pack('<I', 0)
        path = tmp_path / 'bomb.mcap'
        path.write_bytes(
            b'\x89MCAP0\r\n' + struct.pack('<BQ', 1, len(header)) + header + chunk * count
            + struct.pack('<BQI', 15, 4, 0) + struct.pack('<BQQQI', 2, 20, 0, 0, 0)
            + b'\x89MCAP0\r\n'
        )  # fmt: skip
        return path

    return write


@pytest.mark.parametrize('kind', BOMBS)
def test_chunks_that_would_fill_the_memory(bomb, monkeypatch, kind):
    monkeypatch.setattr(bag_limits, '_SMALL_BAG', 2**20)
    for size, count, claimed, words in (
        (2**27, 1, None, 'a chunk of 134,217,728 bytes; at most 67,108,864'),
        (2**20, 3, None, 'chunks of 3,145,728 bytes'),
        (2**22, 1, 100, '1 damaged chunk was left out'),
    ):
        with pytest.raises(SetcmasError, match=words), open_bag(bomb(kind, size, count, claimed)):
            pass


def test_no_more_is_decompressed_than_a_chunk_says():
    for kind, make in BOMBS.items():
        with pytest.raises(ValueError, match='100 bytes'):
            bag_limits.decompressed(make(2**22), kind, 100)


def test_a_message_or_a_file_that_is_a_bomb(tmp_path, monkeypatch):
    packed = tmp_path / 'bag.mcap.zstd'
    packed.write_bytes(BOMBS['zstd'](2**22))
    monkeypatch.setattr(bag_limits, '_SMALL_BAG', 2**20)
    with pytest.raises(ValueError, match='more than'):
        bag_limits.zstd_content(packed.read_bytes(), 2**20)
    with pytest.raises(SetcmasError, match='at most'):
        bag_limits.decompress_file(packed, tmp_path / 'bag.mcap')


def test_a_record_that_is_larger_than_memory(bomb):
    path = bomb('zstd', 100)
    with path.open('r+b') as file:
        file.seek(8)
        file.write(struct.pack('<BQ', 1, 9 * 10**9))
        file.truncate(10**10)

    with pytest.raises(SetcmasError, match='a record of 9,000,000,000 bytes'), open_bag(path):
        pass


RULE = '=' * 80 + '\n'
DEFINITIONS = {
    'fields': (''.join(f'int8 field{i}\n' for i in range(100_000)), '100,000 are read'),
    'many fields': (''.join(f'int8 a{i}\n' for i in range(9000)) * 2, '10,000|damaged|letters'),
    'cycle': (f'B b\n{RULE}MSG: x/B\nA a\n', 'contains itself'),
    'itself': ('A a\n', 'contains itself'),
    'depth': (
        'T1 a\n' + ''.join(f'{RULE}MSG: x/T{i}\nT{i + 1} a\n' for i in range(1, 900)),
        'nested deeper than 30',
    ),
    'powers': (
        'T1 a\nT1 b\n'
        + ''.join(f'{RULE}MSG: x/T{i}\nT{i + 1} a\nT{i + 1} b\n' for i in range(1, 25))
        + f'{RULE}MSG: x/T25\nint8 a\n',
        'more than 10,000 fields',
    ),
    'array of texts': ('string[1000000000] a\n', 'more than 10,000 fields'),
}  # fmt: skip


@pytest.mark.parametrize('name', DEFINITIONS)
def test_definitions_beyond_the_limits(tmp_path, name):
    text, words = DEFINITIONS[name]
    path = tmp_path / 'strange.mcap'
    with path.open('wb') as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start('ros2', '')
        schema = writer.register_schema('x/msg/A', 'ros2msg', text.encode())
        channel = writer.register_channel('/strange', 'cdr', schema)
        writer.add_message(channel, 1, bytes(8), 1)
        writer.finish()

    with pytest.raises(SetcmasError, match=f"bag '{path}' cannot be read.*({words})"):
        convert(path)


def test_a_message_with_millions_of_elements(store):
    limits = TypeLimits(store.fielddefs, 'visualization_msgs/msg/MarkerArray')
    limits.check(bytes(10**6))
    TypeLimits(store.fielddefs, 'sensor_msgs/msg/Image').check(bytes(3 * 10**7))
    with pytest.raises(TooLargeError, match='2,000,000 elements'):
        TypeLimits(store.fielddefs, 'std_msgs/msg/Float32MultiArray').check(bytes(3 * 10**7))


def test_a_row_with_too_many_values_is_left_out(tmp_path, store, make):
    folder = tmp_path / 'bag'
    sample = make('lab_msgs/msg/Sample', {'labels': ['a'] * 9000})
    with Ros2Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        reading = 'lab_msgs/msg/Reading'
        connection = writer.add_connection('/reading', reading, typestore=store)
        for count in (1, 9):
            message = make(reading, {'samples': [sample] * count})
            writer.write(connection, count, store.serialize_cdr(message, reading))

    report = convert(folder)

    assert report.messages == 1
    assert 'it has more than 50,000 values' in report.notices[0]
