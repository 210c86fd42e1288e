from unittest.mock import Mock

import pytest
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from processes import CTRL, SIMU
from ros_peer import velocity
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from setcmas_ctrl.driving.fleet_pause import FleetPause
from setcmas_simu.ros import qos

pytest.importorskip('rclpy')


LAW = 'def control(robotNo, nbRobots, poses, t):\n    return 0.0, 0.2\n'
MIRROR = (
    'def step(state, command, Ts):\n    return state\n'
    'def command(velocity, pose):\n    return 0.0, -velocity[1], 0.0\n'
)


@pytest.fixture
def law(tmp_path):
    path = tmp_path / 'north.py'
    path.write_text(LAW)
    return str(path)


def is_sent(messages, forward, left):
    """Return whether a command has these speeds, a robot at heading 0 being to go north."""
    return any((m.twist.linear.x, m.twist.linear.y) == (forward, left) for m in messages)


def test_robots_are_driven_by_the_models_that_their_simulator_announces(start, peer, law):
    start(*SIMU, '--nb-robots', '2', '--model', '1:omnidirectional').wait_for_output('simulating')
    commands = [peer.cmd_vel(robot, TwistStamped) for robot in (1, 2)]
    start(*CTRL, '--algo', law)

    peer.wait_for(lambda: is_sent(commands[0], pytest.approx(0.0), pytest.approx(0.2)))
    peer.wait_for(lambda: is_sent(commands[1], pytest.approx(0.2), 0.0))


def test_a_script_with_a_command_of_its_own_is_to_be_given_too(start, peer, law, tmp_path):
    script = tmp_path / 'mirror.py'
    script.write_text(MIRROR)
    start(*SIMU, '--model', str(script)).wait_for_output('simulating')
    commands = peer.cmd_vel(1, TwistStamped)
    process = start(*CTRL, '--algo', law)
    process.wait_for_output(f'add --model {script}')
    peer.wait_for(lambda: is_sent(commands, pytest.approx(0.2), 0.0))
    process.end()
    start(*CTRL, '--algo', law, '--model', str(script))

    peer.wait_for(lambda: is_sent(commands, 0.0, pytest.approx(-0.2)))


def test_the_robot_decides_the_type_when_others_listen_too(start, peer):
    peer.cmd_vel(1, TwistStamped)
    start(*SIMU, '--nb-robots', '1', '--pose', '1:3,3', '--cmd-vel-type', 'twist')
    odometry = peer.odometry(1)
    process = start(*CTRL, '--algo', 'nav_wp')

    peer.wait_for(lambda: odometry and odometry[-1].twist.twist.linear.x > 0.1)
    process.wait_for_output('/tb3_1/cmd_vel carries Twist, but /peer takes TwistStamped')


def test_it_says_when_nothing_listens_to_the_commands(start, peer):
    publisher = peer.node.create_publisher(Odometry, '/tb3_1/odom', 10)
    peer.node.create_timer(0.1, lambda: publisher.publish(Odometry()))
    process = start(*CTRL, '--algo', 'nav_wp', '--nb-robots', '1')

    peer.wait_for(lambda: 'nothing listens to cmd_vel of robot 1' in process.output())


def test_pause_holds_one_robot_or_the_fleet_at_zero_and_an_emergency_stop_to_the_end(start, peer):
    start(*SIMU, '--nb-robots', '2')
    commands = [peer.cmd_vel(robot) for robot in (1, 2)]
    ctrl = start(*CTRL, '--algo', 'consensus')
    ctrl.wait_for_output('controlling')
    pause_first = peer.publisher(Bool, '/tb3_1/pause')
    pause_all = peer.publisher(Bool, '/pause')

    def stands(index):
        return all(velocity(m) == (0.0, 0.0) for m in commands[index][-3:])

    peer.wait_for(lambda: all(commands))
    pause_first.publish(Bool(data=True))
    peer.wait_for(lambda: stands(0) and not stands(1))
    pause_all.publish(Bool(data=True))
    peer.wait_for(lambda: stands(0) and stands(1))
    ctrl.wait_for_output('paused by /pause')
    pause_all.publish(Bool(data=False))
    peer.wait_for(lambda: not stands(0) and not stands(1))
    ctrl.wait_for_output('started by /pause')

    peer.publisher(Bool, '/emergency_stop', qos=qos.LATCHED).publish(Bool(data=True))
    ctrl.wait_for_output('emergency stop: restart this process to continue')
    peer.wait_for(lambda: stands(0) and stands(1))
    pause_all.publish(Bool(data=False))
    pause_first.publish(Bool(data=False))
    assert not peer.call(SetBool, '/controllers/pause', data=False).success
    for messages in commands:
        peer.wait_for_new(messages, 5)
    assert stands(0)
    assert stands(1)


class Robot:
    paused = stopped = False

    def pause(self, paused):
        self.paused = paused


def test_a_flood_of_pauses_does_not_fill_the_terminal(capsys, monkeypatch):
    now = [0.0]
    monkeypatch.setattr('time.monotonic', lambda: now[0])
    pauses = FleetPause(Mock(), [Robot()], Mock(), in_lockstep=False)
    for i in range(1000):
        pauses._on_pause(Bool(data=i % 2 == 0))
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 10
    assert lines[-1] == 'started by /pause; similar lines are hidden for now'

    now[0] = 11.0
    pauses._on_pause(Bool(data=True))
    assert capsys.readouterr().out == 'paused by /pause\n'


def test_an_emergency_stop_holds_in_lockstep_too_while_time_goes_on(start, peer):
    start(*SIMU, '--nb-robots', '1', '--lockstep')
    odometry = peer.odometry(1)
    ctrl = start(*CTRL, '--algo', 'nav_wp')
    peer.wait_for(lambda: odometry and odometry[-1].twist.twist.linear.x > 0.0)

    peer.publisher(Bool, '/emergency_stop', qos=qos.LATCHED).publish(Bool(data=True))
    ctrl.wait_for_output('emergency stop: restart this process to continue')
    peer.wait_for(lambda: odometry[-1].twist.twist.linear.x == 0.0)
    later = peer.wait_for_new(odometry, 20)

    assert all(message.twist.twist.linear.x == 0.0 for message in later)


def test_a_second_controller_of_a_robot_is_noticed(start):
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    first = start(*CTRL, '--algo', 'nav_wp')
    first.wait_for_output('controlling')
    start(*CTRL, '--algo', 'nav_wp')

    first.wait_for_output('another controller also commands robot 1 (/controllers)')


def test_a_controller_that_was_killed_is_no_second_one(start, peer):
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    killed = start(*CTRL, '--algo', 'nav_wp')
    killed.wait_for_output('controlling')

    def commanders():
        found = peer.node.get_publishers_info_by_topic('/tb3_1/cmd_vel')
        return {bytes(one.endpoint_gid) for one in found if one.node_name == 'controllers'}

    peer.wait_for(commanders)
    dead = commanders()
    killed.kill_group()
    again = start(*CTRL, '--algo', 'nav_wp')
    again.wait_for_output('controlling')  # who was killed is still in the graph, as a rule
    peer.wait_for(lambda: commanders() and not commanders() & dead)
    assert 'another controller also commands' not in again.output()


def test_the_type_of_the_commands_can_be_forced_which_is_reported_once(start, peer, law):
    start(*SIMU, '--nb-robots', '3').wait_for_output('simulating')
    plain = peer.cmd_vel(1, Twist)
    process = start(*CTRL, '--algo', law, '--cmd-vel-type', 'twist')

    peer.wait_for(lambda: plain)
    process.wait_for_output(
        '/tb3_1/cmd_vel carries Twist, but /virtual_robots takes TwistStamped '
        '(and 2 more topics); choose with --cmd-vel-type'
    )
