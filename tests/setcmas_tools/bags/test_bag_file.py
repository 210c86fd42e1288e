import shutil

import pytest
from bag_contents import only_file, read

from setcmas_simu.errors import SetcmasError


def test_the_files_of_a_split_bag_are_read_in_the_order_of_time(tmp_path, write_bag, points):
    folder = tmp_path / 'bag'
    folder.mkdir()
    for name, part in (('a_1', points[:120]), ('a_0', points[120:])):
        shutil.move(only_file(write_bag(tmp_path / name, part), '*.mcap'), folder)

    assert read(folder) == (list(range(200)), [])


def test_a_compressed_file_is_to_be_unpacked_first(tmp_path):
    (tmp_path / 'bag.mcap.zstd').write_bytes(b'packed')

    with pytest.raises(SetcmasError, match='is compressed; unpack it first: unzstd'):
        read(tmp_path)


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
