import os
import signal
import stat

import pytest
import yaml
from processes import CTRL, SETCMAS, SIMU, refuses, run_setcmas

from launch_scripts.commands.view import ViewOptions, fleet_views
from setcmas_simu.fleet.rviz_config import rviz_config

pytest.importorskip('rclpy')

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from visualization_msgs.msg import Marker, MarkerArray


def displays(robots, *left_out, experiment=False):
    """Return the displays with a topic, except those of some topics."""
    manager = yaml.safe_load(rviz_config(robots, experiment))['Visualization Manager']
    of_robots = [each for group in manager['Displays'] for each in group.get('Displays', ())]
    shown = [each for each in (*manager['Displays'], *of_robots) if 'Topic' in each]
    return [each for each in shown if each['Topic']['Value'] not in left_out]


TYPES = {'Pose': PoseStamped, 'Odometry': Odometry, 'Marker': Marker, 'MarkerArray': MarkerArray}


def profile(topic):
    """Return the QoS that RViz subscribes with."""
    durability = topic['Durability Policy'].upper().replace(' ', '_')
    reliability = topic['Reliability Policy'].upper().replace(' ', '_')
    assert topic['History Policy'] == 'Keep Last'
    return QoSProfile(
        depth=topic['Depth'],
        durability=DurabilityPolicy[durability],
        reliability=ReliabilityPolicy[reliability],
    )


def test_every_display_gets_messages_of_its_type_from_a_running_fleet(start, peer):
    start(*SIMU, '--nb-robots', '2')
    common = ('--nb-robots', '2', '--robots')
    start(*CTRL, '--algo', 'nav_wp', *common, '1', '--obstacles', 'disc 1 2 0.5')
    start(*CTRL, '--algo', 'traj_tracking', *common, '2')
    shown = displays([1, 2], '/tb3_1/traj_ref', '/tb3_2/wp_ref')  # of the other law
    assert len(shown) == 9
    check_messages(shown, peer)


def test_an_experiment_has_what_is_shown_of_it(start, peer):
    start(*SETCMAS, 'expe', '--emulate', '--algo', 'consensus', '--nb-robots', '1')
    of_others = ('/tb3_1/wp_ref', '/tb3_1/traj_ref', '/obstacles')
    shown = displays([1], *of_others, experiment=True)
    assert {display['Topic']['Value'] for display in shown} == {'/arena', '/mocap/tb3_1/odom'}
    check_messages(shown, peer)


def check_messages(shown, peer):
    """Check that every display gets messages, of its type and with its quality of service."""
    received = {}
    for display in shown:
        kind = TYPES[display['Class'].rpartition('/')[2]]
        topic = display['Topic']
        received[topic['Value']] = peer.listen(kind, topic['Value'], profile(topic))
    peer.wait_for(lambda: all(received.values()))

    for display in shown:
        topic = display['Topic']
        (publisher,) = peer.node.get_publishers_info_by_topic(topic['Value'])
        kind = TYPES[display['Class'].rpartition('/')[2]]
        assert publisher.topic_type == f'{kind.__module__.split(".")[0]}/msg/{kind.__name__}'
        assert publisher.qos_profile.durability == profile(topic).durability
        assert publisher.qos_profile.reliability == profile(topic).reliability


def test_without_rviz_the_robots_run_and_the_browser_is_offered(start, tmp_path):
    environment = {'PATH': str(tmp_path), 'DISPLAY': ':0'}

    simu = start(*SETCMAS, 'simu', '--view', 'rviz', env=environment)
    output = simu.wait_for_output('simulating robot 1')

    assert 'rviz2 is not installed' in output
    assert '--view shows the robots in a browser' in output
    assert simu.end(signal.SIGINT) == 0


def test_a_closed_window_leaves_the_robots_alone(start, tmp_path):
    # A program of this name that ends at once, as RViz 2 does whose window is closed.
    program = tmp_path / 'rviz2'
    program.write_text('#!/bin/sh\necho "shows $(grep -c /pose "$2") robots"\n')
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    environment = {'PATH': f'{tmp_path}:{os.environ["PATH"]}', 'DISPLAY': ':0'}

    simu = start(*SETCMAS, 'simu', '--nb-robots', '3', '--view', 'rviz', env=environment)
    simu.wait_for_output('rviz has ended; everything else continues')
    simu.wait_for_output('[simu] simulating robots 1-3')

    assert '[rviz] shows 3 robots' in simu.output()
    assert simu.end(signal.SIGINT) == 0


@pytest.mark.parametrize(
    ('view', 'is_terminal', 'no_rviz', 'started'),
    [
        ('auto', True, '', ['rviz']),
        ('auto', True, 'rviz2 is not installed', ['view']),
        ('auto', False, '', []),
        ('browser', False, '', ['view']),
        ('none', True, '', []),
    ],
)
def test_what_is_started(monkeypatch, view, is_terminal, no_rviz, started):
    monkeypatch.setattr('launch_scripts.commands.view.why_no_rviz', lambda: no_rviz)
    monkeypatch.setattr('sys.stdout.isatty', lambda: is_terminal, raising=False)
    monkeypatch.delenv('CI', raising=False)
    with fleet_views(ViewOptions(view=view), [1]) as views:
        assert [name for name, _ in views] == started


def test_a_host_that_is_none_is_reported_on_one_line(domain):
    result = run_setcmas('view', '--host', '192.0.2.7')

    assert result.returncode == 2
    assert "host '192.0.2.7' is not an address" in result.stderr
    assert result.stderr.count('\n') == 1


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('run/none',), 'there is no'),
        (('--port', '0'), '--port is 0; it must be a whole number from 1 to'),
    ],
)
def test_mistakes_are_reported_in_one_line(tmp_path, arguments, message):
    refuses('view', *arguments, message=message, cwd=tmp_path)
