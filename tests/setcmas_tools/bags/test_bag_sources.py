from bag_contents import only_file, read, write_compressed
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.bag import open_bag

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
        lost = size - complete_size(whole, size)
        assert len(x) == 200 or not lost or f'the last {lost:,} bytes are inc' in notices[0]
        counts.append(len(x))

    assert counts == sorted(counts)
    assert set(counts) == {0, 40, 80, 120, 160, 200}


def complete_size(mcap, size):
    """Return where the last record that is complete in the first `size` bytes ends."""
    end = 8
    while end + 9 <= size:
        record_end = end + 9 + int.from_bytes(mcap[end + 1 : end + 9], 'little')
        if record_end > size:
            break
        end = record_end
    return end


def test_a_cut_mcap_is_reported(tmp_path, write_bag, points):
    path = only_file(write_bag(tmp_path / 'bag', points), '*.mcap')
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])

    x, (notice,) = read(path)

    assert len(x) == 120
    assert f"'{path}' was cut short: 120 messages up to 3.0 s were read, the last " in notice
    path.write_bytes(whole[:-20])
    assert read(path)[1] == [
        f"'{path}' was not closed properly, its index is missing: all its 200 messages were read"
    ]


def test_damaged_chunk_costs_only_itself(tmp_path, store, points):
    write_compressed(
        tmp_path / 'bag', store, points, CompressionMode.STORAGE, StoragePlugin.MCAP, (49, 99)
    )
    path = only_file(tmp_path / 'bag', '*.mcap')
    content = bytearray(path.read_bytes()[:-20])  # without its index, so that all is scanned
    zstd_magic = b'\x28\xb5\x2f\xfd'
    second_chunk = content.index(zstd_magic, content.index(zstd_magic) + 1)
    content[second_chunk] ^= 0xFF
    path.write_bytes(content)

    x, notices = read(path)

    assert x == [*range(50), *range(100, 200)]
    assert notices[0] == (
        f"'{path}' is damaged: a chunk with a wrong checksum or size, 0.0 to 0.0 s, is left out; "
        '150 messages up to 0.0 s were read'
    )


def test_chunk_that_does_not_fit_its_checksum_is_left_out(tmp_path, store, points):
    path = tmp_path / 'others.mcap'
    with path.open('wb') as stream:
        writer = McapWriter(stream, chunk_size=1000, compression=CompressionType.NONE)
        writer.start(profile='ros2')
        schema = writer.register_schema(POINT, 'ros2msg', b'float32 x\nfloat32 y\nfloat32 z')
        channel = writer.register_channel('/points', 'cdr', schema)
        for time_ns, point in enumerate(points, start=1):
            writer.add_message(channel, time_ns, points_bytes(store, point), time_ns)
        writer.finish()
    content = bytearray(path.read_bytes()[:-20])
    assert content.count(points_bytes(store, points[100])) == 1
    content[content.index(points_bytes(store, points[100])) + 8] ^= 1
    path.write_bytes(content)

    x, notices = read(path)

    assert 150 < len(x) < 200
    assert set(x) < set(range(200))
    assert 100 not in x
    assert 'a chunk with a wrong checksum or size, 0.0 to 0.0 s, is left out' in notices[0]


def points_bytes(store, point):
    return bytes(store.serialize_cdr(point[2], POINT))


def test_a_file_that_grows_is_read_as_it_was_when_it_was_opened(tmp_path, write_bag, points, make):
    later = [('/later', 5.0, make(POINT, {'x': -1.0}))]
    whole = only_file(write_bag(tmp_path / 'bag', [*points, *later]), '*.mcap').read_bytes()
    path = tmp_path / 'growing.mcap'
    path.write_bytes(whole[: len(whole) // 3])

    with open_bag(path) as bag:
        path.write_bytes(whole[:-20])
        x = [topic.type.decode(data).x for topic, _, data in bag.messages()]

    assert x == list(range(len(x)))
    assert 0 < len(x) < len(points)


def test_chunks_that_overlap_are_read_in_the_order_of_time(tmp_path, store, points):
    path = tmp_path / 'others.mcap'
    with path.open('wb') as stream:
        writer = McapWriter(stream, chunk_size=1000)
        writer.start(profile='ros2')
        schema = writer.register_schema(POINT, 'ros2msg', b'float32 x\nfloat32 y\nfloat32 z')
        channel = writer.register_channel('/points', 'cdr', schema)
        for i in (i + 3 - 2 * (i % 4) for i in range(200)):
            writer.add_message(channel, i + 1, points_bytes(store, points[i]), i + 1)
        writer.finish()

    assert read(path) == (list(range(200)), [])
