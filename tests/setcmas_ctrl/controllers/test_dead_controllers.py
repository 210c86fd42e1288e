"""Robots stop whatever becomes of the process that controls them."""

import pytest

pytest.importorskip('rclpy')

from processes import SETCMAS, SIMU
from ros_peer import position

HARM = """
import ctypes, os, signal, time
def control(robotNo, nbRobots, poses, t):
    if robotNo == 2 and t > 0.5:
        {harm}
    return 0.3, 0
"""
STAYS = [  # the process does not end by itself
    'time.sleep(600)',
    pytest.param('sum(range(10**14))', marks=pytest.mark.nightly),
    pytest.param('os.kill(os.getpid(), signal.SIGSTOP)', marks=pytest.mark.nightly),
    pytest.param('import rclpy; rclpy.spin(rclpy.create_node("mine"))', marks=pytest.mark.nightly),
]
ENDS = [
    'os.kill(os.getpid(), signal.SIGKILL)',
    pytest.param('os._exit(0)', marks=pytest.mark.nightly),
    pytest.param('ctypes.string_at(0)', marks=pytest.mark.nightly),
    pytest.param('os.abort()', marks=pytest.mark.nightly),
    pytest.param('os.closerange(0, 256)', marks=pytest.mark.nightly),
    pytest.param('import rclpy; rclpy.shutdown()', marks=pytest.mark.nightly),
]


@pytest.fixture
def robots(start, peer):
    """Simulate two robots; return their odometry."""
    start(*SIMU, '--nb-robots', '2').wait_for_output('simulating')
    return [peer.odometry(robot) for robot in (1, 2)]


def stand(odometry):
    return all(messages[-1].twist.twist.linear.x == 0.0 for messages in odometry)


def move(odometry):
    return all(messages and messages[-1].twist.twist.linear.x > 0.2 for messages in odometry)


@pytest.mark.parametrize('harm', STAYS)
def test_robots_stand_while_their_controller_hangs(start, peer, script, robots, harm):
    process = start(*SETCMAS, 'ctrl', '--algo', script(HARM.format(harm=harm)))
    peer.wait_for(lambda: move(robots))
    peer.wait_for(lambda: stand(robots))

    peer.wait_for(lambda: 'law.py' in process.output())
    assert 'tb3_2' in process.output()
    assert process.end() == 1


@pytest.mark.parametrize('harm', ENDS)
def test_robots_stand_when_their_controller_has_died(start, peer, script, robots, harm):
    process = start(*SETCMAS, 'ctrl', '--algo', script(HARM.format(harm=harm)))
    peer.wait_for(lambda: move(robots))
    peer.wait_for(lambda: stand(robots))

    assert process.wait() == 1
    assert 'law.py' in process.output()
    assert 'tb3_2' in process.output()
    assert 'the other robots continue' not in process.output()


@pytest.mark.nightly
def test_a_script_that_ignores_signals_ends_with_its_process(start, peer, script, robots):
    law = HARM.format(harm='signal.signal(signal.SIGINT, signal.SIG_IGN); signal.alarm(1)')
    process = start(*SETCMAS, 'ctrl', '--algo', script(law))
    peer.wait_for(lambda: move(robots))
    begin = position(robots[1][-1])
    peer.wait_for(lambda: position(robots[1][-1])[0] > begin[0] + 0.6)  # more than 1 s later

    assert process.end() == 0
    peer.wait_for(lambda: stand(robots))
