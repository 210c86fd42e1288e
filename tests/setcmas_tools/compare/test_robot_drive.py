import numpy as np
import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools import simulate
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
    ('guarded', 'nearest', 'V'),
    [(0.0, CMD_VEL, 0.2), (0.1, GUARDED, 0.1)],
    ids=['base hears cmd_vel itself', 'base hears its guard alone'],
)
def test_commands_are_those_that_moved_the_robot(driven, guarded, nearest, V):
    drive = drives(driven({CMD_VEL: 0.2, GUARDED: guarded}), pytest.fail)[1]

    assert drive.topic == nearest
    assert drive.commands[1].max() == V


def test_commands_of_an_offline_run_are_those_of_its_own_si_to_uni(tmp_path):
    script = tmp_path / 'mine.py'
    script.write_text('def si_to_uni(v, pose, komega):\n    return v[0] / 2, komega * v[1]\n')
    run = simulate(lambda *_: (0.2, 0.1), 2, 3.0, si_to_uni=script)
    run.save(tmp_path / 'out')

    for drive in drives(tmp_path / 'out', pytest.fail).values():
        np.testing.assert_allclose(drive.commands[1:], [[0.1] * 15, [0.15] * 15], atol=1e-6)


def test_commands_of_a_run_with_a_function_as_si_to_uni_are_not_known(tmp_path):
    simulate('consensus', 2, 3.0, si_to_uni=lambda *_: (0.1, 0.1)).save(tmp_path / 'out')

    with pytest.raises(SetcmasError, match='has no commands of robots'):
        drives(tmp_path / 'out', pytest.fail)
