"""The real command line of ROS 2, with launch files: `pytest -m ros2_command`, where it is."""

import os
import signal
import sys
from pathlib import Path

import psutil
import pytest
from nav_msgs.msg import Odometry
from processes import gone

pytestmark = pytest.mark.ros2_command
ROS2 = str(Path(sys.executable).parent / 'ros2')
NODES = ('virtual_robot', 'controller', 'si_to_uni')
SIMU, CTRL = ('launch', 'setcmas_simu'), ('launch', 'setcmas_ctrl')
PAGE = Path(__file__).parents[1] / 'docs' / 'ros.md'


@pytest.fixture
def ros2(start, peer, monkeypatch):
    if not Path(ROS2).exists():
        pytest.skip('the command ros2 is not installed')
    monkeypatch.setenv('AMENT_PREFIX_PATH', sys.prefix)
    monkeypatch.setenv('PATH', str(Path(ROS2).parent), prepend=os.pathsep)
    monkeypatch.setenv('ROS2CLI_NO_DAEMON', '1')

    def run(*words):
        """Return what a command prints until it ends."""
        process = start(ROS2, *words)
        peer.wait_for(lambda: process.popen.poll() is not None)  # and answer: it asks all nodes
        assert process.wait() == 0, process.output()
        return process.output()

    run.start = lambda *words: start(ROS2, *words)
    return run


def moves(peer, topic, above=0.0):
    from geometry_msgs.msg import TwistStamped

    commands = peer.listen(TwistStamped, topic)
    peer.wait_for(lambda: any(one.twist.linear.x > above for one in commands))
    return commands


def test_nodes_and_parameters_of_a_fleet_are_listed_and_set(ros2, peer):
    simulator = ros2.start('run', 'setcmas_simu', 'virtual_robot', '--nb-robots', '8')
    controllers = ros2.start('run', 'setcmas_ctrl', 'controller', '--algo', 'nav_wp')
    commands = moves(peer, '/tb3_8/cmd_vel', above=0.1)

    names = {f'/tb3_{i}/{name}' for i in range(1, 9) for name in NODES}
    names |= {'/peer', '/controllers', '/virtual_robots'}
    assert set(ros2('node', 'list', '--no-daemon').split()) == names
    info = ros2('node', 'info', '/tb3_3/si_to_uni', '--no-daemon')
    subscribed, _, published = info.partition('Publishers:')
    assert '/tb3_3/cmd_cart_vel: geometry_msgs/msg/Point32' in subscribed
    assert '/tb3_3/cmd_vel: geometry_msgs/msg/TwistStamped' in published
    listed = ros2('param', 'list', '--no-daemon').splitlines()
    assert {line.strip(':') for line in listed if line[0] == '/'} == names
    assert [line.strip() for line in listed].count('komega') == 9

    assert 'successful' in ros2('param', 'set', '/tb3_3/si_to_uni', 'komega', '2.0')
    assert 'komega: 2.0' in ros2('param', 'dump', '/tb3_3/si_to_uni', '--no-daemon')
    assert 'komega: 1.5' in ros2('param', 'dump', '/tb3_2/si_to_uni', '--no-daemon')
    assert 'successful' in ros2('param', 'set', '/tb3_8/controller', 'vnom', '0.01')
    peer.wait_for(lambda: 0 < abs(commands[-1].twist.linear.x) < 0.011)
    assert 'Max value: 200.0' in ros2('param', 'describe', '/virtual_robots', 'rate')
    for process in (controllers, simulator):
        os.killpg(process.pid, signal.SIGINT)  # as Ctrl-C; `ros2 run` itself passes nothing on
        assert process.wait() == 0


@pytest.mark.parametrize(
    'file', ['ctrl_multi_robots.launch.py', 'evt_triggered_ctrl_multi_robots.launch.py']
)
def test_a_fleet_by_launch_files(ros2, peer, file):
    fleet = ('nb_robots:=2', 'namespace:=/a', 'tb3_2_x0:=1.5', 'rviz_gui:=False')
    odometry = peer.listen(Odometry, '/a/tb3_2/odom')
    simulator = ros2.start(*SIMU, 'simu_multi_robots.launch.py', *fleet)
    peer.wait_for(lambda: odometry)
    place = odometry[0].pose.pose.position
    assert (place.x, place.y) == (1.5, -5.0)  # y as without the argument

    exercise = (file, 'algo:=nav_wp', 'exercise:=True', 'namespace:=/a')
    controllers = ros2.start(*CTRL, *exercise)
    controllers.wait_for_output('controlling robots 1-2')
    assert 'Boolean value is: True' in ros2('param', 'get', '/a/controllers', 'exercise')
    assert controllers.end() == 0
    law = (file, 'algo:=consensus', 'nb_robots:=2', 'namespace:=/a')
    controllers = ros2.start(*CTRL, *law)
    moves(peer, '/a/tb3_2/cmd_vel')
    sends_events = '/a/tb3_2/event_triggered_comm' in ros2('node', 'list', '--no-daemon')
    assert sends_events == ('evt' in file)
    assert controllers.end() == 0
    assert simulator.end() == 0
    assert 'cleanly' in simulator.output()


def test_one_robot_by_launch_files(ros2, peer):
    pose = ('tb3_1_x0:=1.0', 'tb3_1_theta0:=1.57', 'rviz_gui:=False')
    odometry = peer.odometry(1)
    ros2.start(*SIMU, 'simu_mono_robot.launch.py', *pose)
    peer.wait_for(lambda: odometry)
    ros2.start(*CTRL, 'ctrl_mono_robot.launch.py')
    moves(peer, '/tb3_1/cmd_vel')

    assert odometry[0].pose.pose.position.x == 1.0


@pytest.mark.parametrize('file', ['expe_ctrl_mono_robot', 'expe_ctrl_multi_robots'])
def test_an_experiment_by_launch_files_starts_paused(ros2, file):
    expe = ros2.start(
        *('launch', 'setcmas_expe', f'{file}.launch.py', 'options:=--emulate'),
        *['nb_robots:=2'] * ('multi' in file),
    )
    expe.wait_for_output('PAUSED')
    robots = 'robot 1' if 'mono' in file else 'robots 1-2'
    assert f'bridging {robots}: poses' in expe.output()
    assert expe.end() == 0


def test_mistakes_in_arguments_of_launch_files(ros2):
    law = ros2.start(*CTRL, 'ctrl_multi_robots.launch.py', 'algo:=consensu')
    assert 'control laws: bearing_formation' in law.wait_for_output('did you mean consensus?')
    size = ros2.start(*CTRL, 'ctrl_multi_robots.launch.py', 'nb_robots:=two')
    size.wait_for_output("nb_robots is 'two'; it must be a whole number from 1 to 2000")
    pose = ros2.start(*SIMU, 'simu_mono_robot.launch.py', 'tb3_1_x0:=a', 'rviz_gui:=False')
    pose.wait_for_output('must be x, y in m and theta in rad')


@pytest.mark.parametrize('signum', [signal.SIGINT, signal.SIGKILL])
def test_nothing_runs_or_moves_after_launch_has_ended(ros2, peer, signum):
    simulator = ros2.start(*SIMU, 'simu_multi_robots.launch.py', 'nb_robots:=2')
    controllers = ros2.start(*CTRL, 'ctrl_multi_robots.launch.py')
    commands = moves(peer, '/tb3_2/cmd_vel', above=0.01)
    assert '[controller-1]: process started' in controllers.output()
    nodes = [psutil.Process(one.pid).children() for one in (controllers, simulator)]
    controllers.end(signum)  # launch itself passes on nothing but SIGINT

    peer.wait_for(lambda: all(gone(one.pid) for one in nodes[0]))
    peer.wait_for(lambda: commands[-1].twist.linear.x == 0.0)
    simulator.end(signum)
    peer.wait_for(lambda: all(gone(one.pid) for one in nodes[1]))
    assert [len(one) for one in nodes] == [1, 1]


def test_the_launch_file_in_the_docs(ros2, peer, tmp_path):
    from geometry_msgs.msg import PoseStamped

    file = tmp_path / 'fleet.launch.py'
    _, begin, rest = PAGE.read_text().partition('from launch import')
    file.write_text(begin + rest.partition('```')[0])
    poses = peer.listen(PoseStamped, '/where')
    launched = ros2.start('launch', str(file))
    commands = moves(peer, '/a/tb3_2/cmd_vel', above=0.1)
    peer.wait_for(lambda: poses)

    assert max(one.twist.linear.x for one in commands) == pytest.approx(0.3)
    assert '/a/laws' in ros2('node', 'list', '--no-daemon')
    assert 'Double value is: 3.0' in ros2('param', 'get', '/a/tb3_2/virtual_robot', 'x0')
    assert launched.end() == 0
