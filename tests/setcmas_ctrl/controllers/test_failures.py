import signal

import pytest
from processes import CTRL, SETCMAS, SIMU

pytest.importorskip('rclpy')

from ros_peer import velocity


def test_a_slow_fleet_is_reported_as_slow_by_the_wall_s_clock_and_not_as_lost(start, script):
    law = script('import time\ndef control(i, n, p, t):\n    time.sleep(0.06)\n    return 0, 0\n')
    start(*SIMU, '--nb-robots', '5', '--rtf', '5')
    process = start(*CTRL, '--algo', law)

    process.wait_for_output('longer than the control period of 0.04 s')
    process.wait_for_output('s for 5 robots')
    assert 'no pose' not in process.output()


@pytest.mark.parametrize('signum', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_the_last_command_is_zero(start, peer, script, signum):
    law = script('def control(i, n, p, t):\n    return 0.3, 0\n')
    start(*SIMU, '--nb-robots', '3', '--cmd-timeout', '0')  # they keep their last command
    odometry = [peer.odometry(robot) for robot in (1, 2, 3)]
    process = start(*CTRL, '--algo', law)
    peer.wait_for(lambda: all(o and o[-1].twist.twist.linear.x > 0.2 for o in odometry))

    process.popen.send_signal(signum)

    peer.wait_for(lambda: all(o[-1].twist.twist.linear.x == 0.0 for o in odometry))
    assert process.wait() == 0
    assert 'Traceback' not in process.output()


HARM = """
import ctypes, os, signal, time
def control(robotNo, nbRobots, poses, t):
    if robotNo == 2 and t > 0.5:
        {harm}
    return 0.3, 0
"""
STAYS = [  # the process does not end by itself
    'time.sleep(600)',
    pytest.param('os.kill(os.getpid(), signal.SIGSTOP)', marks=pytest.mark.nightly),
]
ENDS = [
    'os.kill(os.getpid(), signal.SIGKILL)',
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
    told = ('control of law.py for tb3_2', 'tb3_2: control has not returned')
    peer.wait_for(lambda: any(text in process.output() for text in told))

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


def test_a_robot_whose_odometry_ends_is_commanded_zero(start, peer, script):
    law = script('def control(i, n, p, t):\n    return 0.3, 0\n')
    first = start(*SIMU, '--nb-robots', '2', '--robots', '1')
    start(*SIMU, '--nb-robots', '2', '--robots', '2')
    commands = [peer.cmd_vel(robot) for robot in (1, 2)]
    process = start(*CTRL, '--algo', law, '--nb-robots', '2')
    peer.wait_for(lambda: all(commands))
    first.end(signal.SIGKILL)

    peer.wait_for(lambda: velocity(commands[0][-1]) == (0.0, 0.0))
    process.wait_for_output('robot 1: no pose for')
    peer.wait_for_new(commands[1], 2)
    peer.wait_for(lambda: velocity(commands[1][-1])[0] == pytest.approx(0.3))


def test_a_script_that_shuts_ros_down_while_loading_is_reported(start, script):
    law = 'import rclpy\nrclpy.shutdown()\ndef control(a, b, c, d):\n    return 0, 0\n'
    start(*SIMU, '--nb-robots', '1')
    process = start(*CTRL, '--algo', script(law))

    assert process.wait() == 2
    assert 'law.py has shut down ROS while loading' in process.output()
    assert 'Traceback' not in process.output()


def test_a_script_that_sets_an_alarm_goes_on_when_it_rings(start, script):
    law = script(
        """
        import signal
        signal.alarm(1)
        def control(robotNo, nbRobots, poses, t):
            if t > 1.5:
                print('goes on')
            return 0, 0
        """
    )
    start(*SIMU, '--nb-robots', '1')

    start(*CTRL, '--algo', law).wait_for_output('goes on')
