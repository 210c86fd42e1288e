"""`--watch`: files are edited while a fleet runs."""

import os
import time
from pathlib import Path

import pytest
from processes import CTRL, SIMU

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from ros_peer import position, velocity
from std_msgs.msg import Bool, UInt16

from setcmas_ctrl.controllers.script_reloader import SETTLED_S, FileWatch


def test_a_save_is_noticed_once_it_has_settled(tmp_path):
    path = tmp_path / 'law.py'
    path.write_text('a')
    watch = FileWatch([path])
    assert not watch.poll([path], 0.0)

    path.write_text('half of')
    assert not watch.poll([path], 1.0)
    path.write_text('half of the file')
    assert not watch.poll([path], 1.0 + SETTLED_S)  # it has changed again
    assert watch.poll([path], 1.0 + 2 * SETTLED_S)
    assert not watch.poll([path], 1.0 + 3 * SETTLED_S)


def test_a_file_of_the_same_size_and_time_that_takes_the_name_is_noticed(tmp_path):
    path, other = tmp_path / 'law.py', tmp_path / 'law.tmp'
    path.write_text('a')
    other.write_text('b')
    os.utime(other, ns=(path.stat().st_atime_ns, path.stat().st_mtime_ns))
    watch = FileWatch([path])

    other.replace(path)

    assert not watch.poll([path], 0.0)
    assert watch.poll([path], SETTLED_S)


def test_a_file_that_is_away_or_empty_for_a_moment_is_waited_for(tmp_path):
    path = tmp_path / 'law.py'
    path.write_text('a')
    watch = FileWatch([path])

    path.unlink()
    assert not watch.poll([path], 0.0)
    assert not watch.poll([path], SETTLED_S)
    path.touch()
    assert not watch.poll([path], 2 * SETTLED_S)
    assert not watch.poll([path], 3 * SETTLED_S)
    path.write_text('bc')
    assert not watch.poll([path], 4 * SETTLED_S)
    assert watch.poll([path], 5 * SETTLED_S)


def test_a_file_that_is_new_counts_as_saved(tmp_path):
    first, second = tmp_path / 'law.py', tmp_path / 'helper.py'
    first.write_text('a')
    watch = FileWatch([first])
    second.write_text('b')

    assert not watch.poll([first, second], 1.0)
    assert watch.poll([first, second], 1.0 + SETTLED_S)
    assert watch.saved == {second}
    assert not watch.poll([first, second], 1.0 + 2 * SETTLED_S)


LAW = """
import gain_of_watched
calls = 0
print('loaded')
def control(robotNo, nbRobots, poses, t):
    global calls
    calls += 1
    if calls == 1:
        print(f'first call at t = {t:g}')
    return gain_of_watched.V, SPEED
"""


def save(path: Path, text: str) -> None:
    """Save as editors do: into another file, which then takes the name."""
    other = path.with_suffix('.swp')
    other.write_text(text)
    other.replace(path)


@pytest.mark.nightly
def test_the_newest_version_controls_the_robots(start, peer, tmp_path):
    law, helper = tmp_path / 'law.py', tmp_path / 'gain_of_watched.py'
    helper.write_text('V = 0.1\n')
    law.write_text(LAW.replace('SPEED', '0.0'))
    start(*SIMU, '--nb-robots', '2', '--cmd-timeout', '1').wait_for_output('simulating')
    odometry = peer.odometry(2)
    commands = [peer.cmd_cart_vel(robot) for robot in (1, 2)]
    process = start(*CTRL, '--algo', str(law), '--watch', cwd=tmp_path)

    def wait_for_velocity(vx, vy):
        peer.wait_for(
            lambda: all(c and (c[-1].x, c[-1].y) == pytest.approx((vx, vy)) for c in commands)
        )

    wait_for_velocity(0.1, 0)
    before = position(odometry[-1])
    saved = time.time()
    save(law, LAW.replace('SPEED', '0.2'))
    wait_for_velocity(0.1, 0.2)
    process.wait_for_output('reloaded for robots 1-2; t = 0')
    peer.wait_for(lambda: process.output().count('tb3_2: first call at t = 0\n') == 2)
    assert abs(position(odometry[-1])[0] - before[0]) < 0.2 * (time.time() - saved) + 0.2

    helper.write_text('V = 0.05\n')
    wait_for_velocity(0.05, 0.2)

    save(law, LAW.replace('SPEED', '0.2').replace('return', 'retrun'))
    wait_for_velocity(0, 0)
    peer.wait_for(lambda: velocity(odometry[-1].twist)[0] == 0)
    message = process.wait_for_output('law.py was saved with a mistake')
    assert 'law.py, line 10: SyntaxError' in message
    save(law, LAW.replace('SPEED', '1 / (robotNo - 2)'))
    process.wait_for_output('tb3_2 at t = 0.0 s: law.py, line 10: ZeroDivisionError')
    assert 'tb3_1 at t' not in process.output()

    save(law, LAW.replace('SPEED', '0.1'))
    wait_for_velocity(0.05, 0.1)
    assert process.end() == 1  # an earlier version failed
    assert 'Traceback' not in process.output()


def test_in_an_experiment_it_waits_for_the_pause(start, peer, tmp_path):
    law = tmp_path / 'law.py'
    law.write_text('def control(i, n, p, t):\n    return 0.1, 0\n')
    pose, paused = Odometry(), Bool(data=False)
    pose.pose.pose.orientation.w = 1.0
    poses = peer.publisher(Odometry, '/mocap/tb3_1/odom', listeners=0)
    pause = peer.publisher(Bool, '/paused', listeners=0)
    peer.node.create_timer(0.1, lambda: (poses.publish(pose), pause.publish(paused)))
    command = peer.cmd_cart_vel(1)
    process = start(*CTRL, '--algo', str(law), '--watch', '--experiment', '--nb-robots', '1')
    peer.wait_for(lambda: command and command[-1].x == pytest.approx(0.1))

    save(law, 'def control(i, n, p, t):\n    return 0.2, 0\n')
    peer.wait_for(lambda: 'pause to load the new one' in process.output())
    peer.wait_for_new(command, 5)
    assert command[-1].x == pytest.approx(0.1)

    paused.data = True
    peer.wait_for(lambda: 'law.py was saved and reloaded' in process.output())
    paused.data = False
    peer.wait_for(lambda: command[-1].x == pytest.approx(0.2))


@pytest.mark.nightly
def test_a_saved_triggering_condition_is_reloaded_with_the_law(start, peer, tmp_path):
    law, when = tmp_path / 'law.py', tmp_path / 'when.py'
    law.write_text('def control(i, n, p, t):\n    return 0.1, 0\n')
    when.write_text('def ctc(pos, last_pos, t):\n    return False\n')
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    events = peer.listen(UInt16, '/tb3_1/trig_event')
    options = ['--event-triggered', '--ctc', str(when), '--watch']
    process = start(*CTRL, '--algo', str(law), *options)
    peer.wait_for_new(events, 3)
    assert not events[-1].data

    save(when, 'def ctc(pos, last_pos, t):\n    return True\n')
    peer.wait_for(lambda: [event.data for event in events[-3:]] == [1, 1, 1])
    process.wait_for_output('when.py was saved and reloaded for robot 1; t = 0')

    save(when, 'def ctc(pos, last_pos, t):\n    return unknown\n')
    process.wait_for_output("name 'unknown' is not defined")


def test_a_saved_si_to_uni_is_reloaded_with_the_law(start, peer, tmp_path):
    own = tmp_path / 'own.py'
    own.write_text('def si_to_uni(velocity, pose, komega):\n    return 0.1, 0.0\n')
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    commands = peer.cmd_vel(1)
    process = start(*CTRL, '--algo', 'nav_wp', '--si-to-uni', str(own), '--watch')
    peer.wait_for(lambda: commands and velocity(commands[-1]) == (0.1, 0.0))

    save(own, 'def si_to_uni(velocity, pose, komega):\n    return 0.2, 0.0\n')
    peer.wait_for(lambda: velocity(commands[-1]) == (0.2, 0.0))
    process.wait_for_output('own.py was saved and reloaded for robot 1; t = 0')


def test_a_version_with_a_mistake_at_the_end_is_no_success(start, tmp_path):
    law = tmp_path / 'law.py'
    law.write_text('def control(i, n, p, t):\n    return 0.1, 0\n')
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    process = start(*CTRL, '--algo', str(law), '--watch')
    process.wait_for_output('controlling')
    save(law, 'def control(i, n, p, t):\n    return 0.1,, 0\n')
    process.wait_for_output('law.py was saved with a mistake')

    assert process.end() == 1
