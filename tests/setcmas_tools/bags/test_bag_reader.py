import shutil
import sqlite3

import pytest
from bag_contents import damage, only_file, read, write_compressed
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionMode, StoragePlugin
from rosbags.typesys import Stores, get_typestore

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.bag_reader import open_bag

POINT = 'geometry_msgs/msg/Point32'


@pytest.mark.parametrize('plugin', ['mcap', 'sqlite3'])
@pytest.mark.parametrize('form', ['folder', 'without metadata', 'lone file', 'run'])
def test_rosbag2_bags_of_each_form(tmp_path, write_bag, points, plugin, form):
    bag = write_bag(tmp_path / 'bag', points, plugin)
    if form == 'without metadata':
        (bag / 'metadata.yaml').unlink()
    path = {'lone file': only_file(bag, 'bag.*[3p]'), 'run': tmp_path}.get(form, bag)

    with open_bag(path) as opened:
        (topic,) = opened.topics
        times = [time_ns - opened.start_ns for _, time_ns, _ in opened.messages()]

    assert read(path) == (list(range(200)), [])
    assert (topic.name, topic.msgtype, topic.count) == ('/tb3_1/cmd_cart_vel', POINT, 200)
    assert times == [round(i * 25e6) for i in range(200)]
    assert opened.end_ns - opened.start_ns == times[-1]


def test_ros1_bag(tmp_path, write_ros1_bag, points):
    bag = write_ros1_bag(tmp_path / 'old.bag', points)

    assert read(bag) == (list(range(200)), [])


def test_type_that_this_machine_does_not_know(tmp_path, write_bag, write_ros1_bag, make):
    reading = make('lab_msgs/msg/Reading', {'name': 'probe'})
    bags = [
        write_bag(tmp_path / 'mcap', [('/probe', 0, reading)]),
        write_bag(tmp_path / 'sqlite3', [('/probe', 0, reading)], 'sqlite3'),
        write_ros1_bag(tmp_path / 'ros1.bag', [('/probe', 0, reading)]),
    ]
    for path in bags:
        with open_bag(path) as bag:
            ((topic, _, data),) = bag.messages()
            assert topic.decode(data).name == 'probe'


def test_bag_from_before_iron_has_no_definitions(tmp_path, write_bag, points, make):
    probe = [('/probe', 6, make('lab_msgs/msg/Reading'))]
    file = only_file(write_bag(tmp_path / 'bag', points + probe, 'sqlite3'), '*.db3')
    database = sqlite3.connect(file)
    database.executescript('DROP TABLE message_definitions; DROP TABLE schema;')
    database.close()

    x, (notice,) = read(file)

    assert x == list(range(200))
    assert notice.startswith('topic /probe (lab_msgs/msg/Reading) is left out: ')


@pytest.mark.parametrize(
    ('name', 'content', 'reason'),
    [
        ('missing.mcap', None, 'there is no bag'),
        ('', None, 'is not a bag; it must be'),
        ('notes.txt', b'hello', 'is not a bag; it must be'),
        ('empty.mcap', b'', 'no messages were read'),
        ('wrong.mcap', b'hello' * 20, 'no messages were read'),
        ('wrong.db3', b'hello' * 20, 'it must be whole'),
        ('wrong.bag', b'hello' * 20, 'cannot be read (File magic is invalid.)'),
    ],
)
def test_other_files_get_one_line(tmp_path, name, content, reason):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)

    with pytest.raises(SetcmasError) as error, open_bag(path):
        pass

    assert str(path) in str(error.value)
    assert reason in str(error.value)
    assert '\n' not in str(error.value)


@pytest.mark.parametrize('plugin', ['mcap', 'sqlite3'])
def test_bag_without_messages(tmp_path, write_bag, plugin):
    bag = write_bag(tmp_path / 'bag', [], plugin)

    with pytest.raises(SetcmasError, match='holds no messages'), open_bag(bag):
        pass


def test_topics_of_ros1_without_a_slash_have_the_same_names(tmp_path, make):
    store = get_typestore(Stores.ROS1_NOETIC)
    with Ros1Writer(tmp_path / 'old.bag') as writer:
        connection = writer.add_connection('tb3_1/point', POINT, typestore=store)
        writer.write(connection, 1, store.serialize_ros1(make(POINT), POINT))

    with open_bag(tmp_path / 'old.bag') as bag:
        assert [topic.name for topic in bag.topics] == ['/tb3_1/point']


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
        assert 'is cut short' in notices[0]
        counts.append(len(x))

    assert counts == sorted(counts)
    assert set(counts) == {0, 40, 80, 120, 160, 200}


@pytest.mark.parametrize('has_index', [True, False])
def test_what_is_read_up_to_a_damaged_chunk_is_told(tmp_path, store, points, has_index):
    write_compressed(
        tmp_path / 'bag', store, points, CompressionMode.STORAGE, StoragePlugin.MCAP, (49, 99)
    )
    path = only_file(tmp_path / 'bag', '*.mcap')
    damage(path, 1)
    path.write_bytes(path.read_bytes() if has_index else path.read_bytes()[:-20])

    x, (notice,) = read(path)

    assert x == list(range(50))
    assert f"'{path}' is " in notice
    assert ('later messages' if has_index else '50 messages up to 0.0 s were') in notice


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


def test_files_that_are_missing_are_named(tmp_path, write_bag, points):
    metadata = write_bag(tmp_path / 'bag', points) / 'metadata.yaml'
    metadata.write_text(metadata.read_text().replace('- bag.mcap', '- bag.mcap\n  - second.mcap'))

    x, (notice,) = read(tmp_path / 'bag')

    assert x == list(range(200))
    assert 'files are missing' in notice
