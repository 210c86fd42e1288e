import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import TwistStamped
from processes import CTRL, SIMU

LAW = 'def control(robotNo, nbRobots, poses, t):\n    return 0.0, 0.2\n'
MIRROR = (
    'def step(state, command, Ts):\n    return state\n'
    'def command(velocity, pose):\n    return 0.0, -velocity[1], 0.0\n'
)


@pytest.fixture
def law(script):
    return script(LAW)


def is_sent(messages, forward, left):
    """Return whether a command has these speeds, a robot at heading 0 being to go north."""
    return any((m.twist.linear.x, m.twist.linear.y) == (forward, left) for m in messages)


def test_robots_are_driven_by_the_models_that_their_simulator_announces(start, peer, law):
    start(*SIMU, '--nb-robots', '2', '--model', '1:omnidirectional').wait_for_output('simulating')
    commands = [peer.cmd_vel(robot, TwistStamped) for robot in (1, 2)]
    start(*CTRL, '--algo', law)

    peer.wait_for(lambda: is_sent(commands[0], pytest.approx(0.0), pytest.approx(0.2)))
    peer.wait_for(lambda: is_sent(commands[1], pytest.approx(0.2), 0.0))


def test_a_script_with_a_command_of_its_own_is_to_be_given_too(start, peer, law, script):
    mirror = script(MIRROR, 'mirror.py')
    start(*SIMU, '--nb-robots', '1', '--model', mirror).wait_for_output('simulating')
    commands = peer.cmd_vel(1, TwistStamped)
    process = start(*CTRL, '--algo', law)
    process.wait_for_output(f'add --model {mirror}')
    peer.wait_for(lambda: is_sent(commands, pytest.approx(0.2), 0.0))
    process.end()
    start(*CTRL, '--algo', law, '--model', mirror)

    peer.wait_for(lambda: is_sent(commands, 0.0, pytest.approx(-0.2)))
