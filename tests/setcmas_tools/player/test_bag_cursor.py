import pytest

from setcmas_tools.bags.reader import open_bag
from setcmas_tools.player.bag_cursor import BagCursor


@pytest.fixture(params=['mcap', 'sqlite3'])
def bag(tmp_path, write_bag, make, request):
    """A bag with /number at 0.0, 0.1, ... 0.9 s, and /latched, /other at 0.25 s."""
    messages = [(f'/{n}', 0.25, make('std_msgs/msg/UInt16')) for n in ('latched', 'other')]
    messages += [('/number', i / 10, make('std_msgs/msg/UInt16', {'data': i})) for i in range(10)]
    path = write_bag(tmp_path / 'bag', sorted(messages, key=lambda one: one[1]), request.param)
    with open_bag(path) as bag:
        yield bag


@pytest.fixture
def cursor(bag):
    played = [topic for topic in bag.topics if topic.name != '/other']
    return BagCursor(bag, played, [topic for topic in played if topic.name == '/latched'])


def numbers(messages):
    return [t.type.decode(data).data if t.name == '/number' else t.name for t, data in messages]


def test_messages_come_when_their_time_has_come(cursor):
    assert numbers(cursor.until(0.05)) == [0]
    assert numbers(cursor.until(0.05)) == []
    assert cursor.next_s == pytest.approx(0.1)
    assert numbers(cursor.until(0.31)) == [1, 2, '/latched', 3]
    assert numbers(cursor.until(99.0)) == [4, 5, 6, 7, 8, 9]
    assert cursor.next_s is None
    assert cursor.duration == pytest.approx(0.9)


def test_whoever_goes_to_a_time_knows_what_was_latched_before(cursor):
    assert numbers(cursor.move_to(0.75)) == ['/latched']
    assert numbers(cursor.until(0.81)) == [8]
    assert numbers(cursor.move_to(0.1)) == []
    assert numbers(cursor.until(0.21)) == [1, 2]
