import pytest
from bag_contents import read


@pytest.mark.parametrize('suffix', ['.bag', '.bag.active'])
def test_ros1_bag_without_index(tmp_path, write_ros1_bag, points, suffix):
    whole = write_ros1_bag(tmp_path / 'whole.bag', points).read_bytes()
    path = tmp_path / f'killed{suffix}'
    path.write_bytes(whole[: whole.rindex(b'chunk_pos=') - 200])

    x, (notice,) = read(path)

    assert x == list(range(200))
    assert f"'{path}' was not closed properly: 200 messages up to 5.0 s were read" in notice


def test_ros1_bag_whose_last_chunk_was_never_finished(tmp_path, write_ros1_bag, points):
    whole = bytearray(write_ros1_bag(tmp_path / 'whole.bag', points).read_bytes())
    # rosbag writes the size of a chunk when the chunk is full; until then it is 0.
    size = whole.index(b'size=')
    chunk = size + len(b'size=') + 4
    whole[chunk : chunk + 4] = bytes(4)
    path = tmp_path / 'killed.bag'
    path.write_bytes(whole[: len(whole) // 2])

    x, (notice,) = read(path)

    assert 50 < len(x) < 150
    assert x == list(range(len(x)))
    assert 'bytes are incomplete' in notice
