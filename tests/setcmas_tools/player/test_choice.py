import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.reader import open_bag
from setcmas_tools.player.choice import Choice

pytest.importorskip('rclpy')


@pytest.fixture
def bag(tmp_path, write_bag, make):
    names = {'/number': 'UInt16', '/tb3_1/reset': 'Empty', '/clock': 'Bool', '/twice': 'Bool'}
    messages = [(name, 0, make(f'std_msgs/msg/{kind}')) for name, kind in names.items()]
    messages += [
        ('/twice', 1, make('std_msgs/msg/Empty')),
        ('/lab', 1, make('lab_msgs/msg/Reading')),
    ]
    with open_bag(write_bag(tmp_path / 'bag', messages)) as bag:
        yield bag


def test_what_is_left_out_is_told(bag):
    choice = Choice(bag, None, own_clock=True)

    assert [topic.name for topic in choice.classes] == ['/number', '/twice']
    assert choice.notes == [
        'not played: /clock (--clock takes its place)',
        'not played: /lab (no Python package lab_msgs with it is installed)',
        'not played: /tb3_1/reset (no robot moves because of a recording)',
        'not played: /twice (recorded with two types)',
    ]


@pytest.mark.parametrize(
    ('wanted', 'told'),
    [
        (['number', '/nobody'], 'there is no topic /nobody in the bag'),
        (['/tb3_1/reset'], 'no topic is left to play; not played: /tb3_1/reset'),
    ],
)
def test_topics_that_cannot_be_played(bag, wanted, told):
    with pytest.raises(SetcmasError, match=told):
        Choice(bag, wanted, own_clock=False)
