import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.bag import open_bag
from setcmas_tools.bags.playback import BagCursor, PlayClock, is_command, played_topics


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
    return BagCursor(bag, played)


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


pytest.importorskip('rclpy')


@pytest.fixture
def choosable_bag(tmp_path, write_bag, make):
    names = {'/number': 'UInt16', '/tb3_1/reset': 'Empty', '/clock': 'Bool', '/twice': 'Bool'}
    messages = [(name, 0, make(f'std_msgs/msg/{kind}')) for name, kind in names.items()]
    messages += [
        ('/twice', 1, make('std_msgs/msg/Empty')),
        ('/lab', 1, make('lab_msgs/msg/Reading')),
    ]
    with open_bag(write_bag(tmp_path / 'choosable_bag', messages)) as choosable_bag:
        yield choosable_bag


def test_omissions_are_reported(choosable_bag):
    classes, notes = played_topics(choosable_bag, own_clock=True)

    assert [topic.name for topic in classes] == ['/number', '/twice']
    assert notes == [
        'not played: /clock (--clock takes its place)',
        'not played: /lab (no Python package lab_msgs with it is installed)',
        'not played: /tb3_1/reset (no robot moves because of a recording)',
        'not played: /twice (recorded with two types)',
    ]


def test_a_bag_of_commands_alone_is_refused(tmp_path, write_bag, make):
    messages = [('/tb3_1/reset', 0, make('std_msgs/msg/Empty'))]
    with (
        open_bag(write_bag(tmp_path / 'commands', messages)) as bag,
        pytest.raises(SetcmasError, match='no topic is left to play; not played: /tb3_1/reset'),
    ):
        played_topics(bag, own_clock=False)


STAMPED = 'geometry_msgs/msg/TwistStamped'


@pytest.mark.parametrize(
    ('name', 'msgtype'),
    [
        ('/tb3_1/cmd_vel', STAMPED),
        ('/tb3_1/cmd_vel_wanted', STAMPED),
        ('/husky/velocity_controller/reference', 'geometry_msgs/msg/Twist'),
        ('/cmd_vel_nav', 'custom_msgs/msg/Velocity'),
        ('/pause', 'std_msgs/msg/Bool'),
        ('/tb3_1/pause', 'std_msgs/msg/Bool'),
        ('/paused', 'std_msgs/msg/Bool'),
        ('/emergency_stopped', 'std_msgs/msg/Bool'),
        ('/tb3_1/cmd_vel_guarded', 'custom_msgs/msg/Velocity'),
        ('/tb3_1/guard_state', 'diagnostic_msgs/msg/DiagnosticStatus'),
        ('/tb3_2/reset', 'std_msgs/msg/Empty'),
        ('/emulated_lab/fault', 'std_msgs/msg/String'),
        ('/bridge_state', 'diagnostic_msgs/msg/DiagnosticArray'),
        ('/fleet_time', 'sensor_msgs/msg/TimeReference'),
        ('/joy', 'sensor_msgs/msg/Joy'),
    ],
)
def test_commands_to_robots_are_never_played(name, msgtype):
    assert is_command(name, msgtype)


@pytest.mark.parametrize(
    ('name', 'msgtype'),
    [
        ('/tb3_1/odom', 'nav_msgs/msg/Odometry'),
        ('/tb3_1/cmd_cart_vel', 'geometry_msgs/msg/Point32'),
        ('/fleet', 'std_msgs/msg/String'),
        ('/scan', 'sensor_msgs/msg/LaserScan'),
    ],
)
def test_measurements_and_reports_are_played(name, msgtype):
    assert not is_command(name, msgtype)


def test_time_passes_at_the_rate():
    clock = PlayClock(10.0, now=100.0)

    assert clock.at(100.5) == 5.0
    assert clock.wait_s(10.0, 100.5) == 0.5
    assert clock.wait_s(1.0, 100.5) == 0.0


def test_a_pause_takes_no_time():
    clock = PlayClock(2.0, now=0.0)

    clock.toggle(1.0)
    assert clock.at(50.0) == 2.0
    clock.toggle(60.0)
    assert clock.at(61.0) == 4.0
