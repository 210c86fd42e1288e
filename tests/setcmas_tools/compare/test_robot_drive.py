import pytest

from setcmas_tools.compare.robot_drive import drives

TWIST = 'geometry_msgs/msg/TwistStamped'
CMD_VEL, GUARDED = '/tb3_1/cmd_vel', '/tb3_1/cmd_vel_guarded'


@pytest.fixture
def driven(tmp_path, make, write_bag):
    """A function that writes the bag of a robot whose base was sent speeds on some topics."""

    def driven(speeds):
        messages = []
        for i in range(20):
            messages.append(('/tb3_1/odom', i / 10, make('nav_msgs/msg/Odometry')))
            for topic, V in speeds.items():
                messages.append((topic, i / 10, make(TWIST, {'twist.linear.x': V * (i > 3)})))
        return write_bag(tmp_path / 'bag', messages)

    return driven


@pytest.mark.parametrize(
    ('guarded', 'V'),
    [(0.0, 0.2), (0.1, 0.1)],
    ids=['base hears cmd_vel itself', 'base hears its guard alone'],
)
def test_commands_are_those_that_moved_the_robot(driven, guarded, V):
    drive = drives(driven({CMD_VEL: 0.2, GUARDED: guarded}), pytest.fail)[1]

    assert drive.commands[1].max() == V
