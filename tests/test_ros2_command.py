"""The real command line of ROS 2, with launch files: `pytest -m ros2_command`, where it is."""

import os
import signal
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.ros2_command
ROS2 = str(Path(sys.executable).parent / 'ros2')
PAGE = Path(__file__).parents[1] / 'docs' / 'ros.md'


@pytest.fixture
def ros2(start, peer, monkeypatch):
    if not Path(ROS2).exists():
        pytest.skip('the command ros2 is not installed')
    monkeypatch.setenv('AMENT_PREFIX_PATH', sys.prefix)
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


def test_parameters_of_a_fleet_are_listed_and_set(ros2, peer):
    simulator = ros2.start('run', 'setcmas_simu', 'virtual_robot', '--nb-robots', '8')
    controllers = ros2.start('run', 'setcmas_ctrl', 'controller', '--algo', 'consensus')
    moves(peer, '/tb3_8/cmd_vel')

    listed = ros2('param', 'list', '--no-daemon')
    assert [line for line in listed.splitlines() if line[0] == '/'] == [
        '/controllers:',
        '/peer:',
        '/virtual_robots:',
    ]
    assert 'vnom: 0.5' in ros2('param', 'dump', '/controllers', '--no-daemon')
    assert 'successful' in ros2('param', 'set', '/controllers', 'vnom', '0.3', '--no-daemon')
    assert 'Max value: 100.0' in ros2('param', 'describe', '/virtual_robots', 'rtf', '--no-daemon')
    for process in (controllers, simulator):
        os.killpg(process.pid, signal.SIGINT)  # as Ctrl-C; `ros2 run` itself passes nothing on
        assert process.wait() == 0


def test_a_message_of_a_law_is_echoed_as_in_the_docs(ros2, peer, tmp_path):
    (tmp_path / 'law.py').write_text(
        'from setcmas_ctrl import network\n'
        'def control(robotNo, nbRobots, poses, t):\n'
        "    network.send({'x': 1.5, 'goal': [2, 3]})\n"
        '    return 0.1, 0\n'
    )
    ros2.start('run', 'setcmas_simu', 'virtual_robot', '--nb-robots', '1')
    law = str(tmp_path / 'law.py')
    ros2.start('run', 'setcmas_ctrl', 'controller', '--algo', law)
    moves(peer, '/tb3_1/cmd_vel')

    echoed = ros2('topic', 'echo', '--once', '/tb3_1/message').splitlines()
    _, _, shown = PAGE.read_text().partition('/tb3_1/message\nlayout')
    wanted = f'layout{shown}'.partition('```')[0].splitlines()
    assert len(wanted) == 14
    assert [line for line in wanted if line != '- 4.2'] == echoed[:10] + echoed[11:14]


def test_the_launch_files(ros2, peer):
    launch = ('launch', 'launch_scripts')
    fleet = ('nb_robots:=2', 'namespace:=/a')
    simulator = ros2.start(*launch, 'simu_multi_robots.launch.py', *fleet)
    controllers = ros2.start(
        *launch, 'ctrl_multi_robots.launch.py', 'algo:=consensus', 'namespace:=/a'
    )
    moves(peer, '/a/tb3_2/cmd_vel')
    assert controllers.end() == 0
    assert simulator.end() == 0

    assert 'cleanly' in simulator.output()
    assert 'control laws: bearing_formation' in ros2.start(
        *launch, 'ctrl_multi_robots.launch.py', 'algo:=consensu'
    ).wait_for_output('did you mean consensus?')


def test_robots_stand_after_the_controller_of_a_launch_file_has_died(ros2, peer, tmp_path):
    law = tmp_path / 'law.py'
    law.write_text(
        'import os\ndef control(robotNo, nbRobots, poses, t):\n'
        '    return (0.3, 0) if t < 1 else os.kill(os.getpid(), 9)\n'
    )
    from nav_msgs.msg import Odometry

    launch = ('launch', 'launch_scripts')
    ros2.start(*launch, 'simu_multi_robots.launch.py', 'nb_robots:=2', 'namespace:=/a')
    controllers = ros2.start(
        *launch, 'ctrl_multi_robots.launch.py', f'algo:={law}', 'namespace:=/a'
    )
    odometry = peer.listen(Odometry, '/a/tb3_2/odom')
    peer.wait_for(lambda: odometry and odometry[-1].twist.twist.linear.x > 0.1)
    peer.wait_for(lambda: controllers.popen.poll() is not None)

    peer.wait_for(lambda: odometry[-1].twist.twist.linear.x == 0.0)


def test_nodes_end_with_zero_velocity_when_launch_dies(ros2, peer):
    launch = ('launch', 'launch_scripts')
    ros2.start(*launch, 'simu_multi_robots.launch.py', 'nb_robots:=2')
    controllers = ros2.start(*launch, 'ctrl_multi_robots.launch.py', 'algo:=consensus')
    commands = moves(peer, '/tb3_2/cmd_vel', above=0.01)
    assert '[controller-1]: process started' in controllers.output()
    controllers.end(signal.SIGTERM)  # launch itself passes nothing on

    peer.wait_for(lambda: commands[-1].twist.linear.x == 0.0)
    peer.wait_for(lambda: not peer.node.get_publishers_info_by_topic('/tb3_2/cmd_vel'))


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
    assert 'Double value is: 3.0' in ros2('param', 'get', '/a/virtual_robots', 'tb3_2.x0')
    assert launched.end() == 0
