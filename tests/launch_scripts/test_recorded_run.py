"""Second runs in a ROS domain, and runs that another program pauses."""

import pytest
import yaml
from processes import NO_WINDOWS, PATIENT_LAB, SETCMAS, SIMU, run_setcmas

pytest.importorskip('rclpy')

from geometry_msgs.msg import TwistStamped
from std_msgs.msg import Bool

LAW = 'def control(i, n, p, t):\n    return 0.2, 0\n'


def commanders(peer, topic):
    """Return the participants that command a robot now."""
    return {
        bytes(info.endpoint_gid[:12]) for info in peer.node.get_publishers_info_by_topic(topic)
    }


@pytest.mark.nightly
def test_a_second_run_commands_nothing(start, peer, tmp_path):
    start(*SIMU, '--nb-robots', '2').wait_for_output('simulating')
    commands = peer.cmd_vel(1)
    (tmp_path / 'law.py').write_text(LAW)
    second = run_setcmas('run', '--algo', 'law.py', '--nb-robots', '2', cwd=tmp_path, **NO_WINDOWS)
    peer.spin(0.2)

    assert second.returncode == 2
    assert 'robots 1-2 are already simulated in ROS domain' in second.stderr
    assert commands == []
    assert [path.name for path in tmp_path.iterdir()] == ['law.py']


@pytest.mark.nightly
def test_a_recorded_experiment_that_cannot_be_restarted_ends_and_says_so(start, peer, tmp_path):
    (tmp_path / 'law.py').write_text(LAW)
    run = ('expe', *PATIENT_LAB, '--algo', 'law.py', '--nb-robots', '1', '--duration', '600')
    process = start(*SETCMAS, *run, '--no-plots', '-o', 'out', cwd=tmp_path, env=NO_WINDOWS)
    process.wait_for_output('started: by command')
    peer.publisher(Bool, '/pause').publish(Bool(data=True))

    assert process.wait() == 1
    detail = 'the robots were paused: by /pause; nothing can start them again'
    assert f'setcmas expe: {detail}' in process.output()
    outcome = yaml.safe_load((tmp_path / 'out' / 'run.yaml').read_text())['outcome']
    assert outcome == {'state': 'not finished', 'detail': detail}


@pytest.mark.nightly
def test_a_second_emulated_experiment_pauses_no_robot(start, peer, tmp_path):
    (tmp_path / 'law.py').write_text(LAW)
    run = ('expe', *PATIENT_LAB, '--algo', 'law.py', '--nb-robots', '1')
    first = start(*SETCMAS, *run, '--duration', '600', cwd=tmp_path, env=NO_WINDOWS)
    commands, paused = peer.listen(TwistStamped, '/tb3_1/cmd_vel'), peer.listen(Bool, '/paused')
    peer.wait_for(lambda: commands and commands[-1].twist.linear.x > 0.0)
    sources = commanders(peer, '/tb3_1/cmd_vel')
    paused.clear()
    second = run_setcmas(*run, '-o', 'second', cwd=tmp_path, **NO_WINDOWS)
    peer.wait_for_new(paused, 5)

    assert second.returncode == 2
    assert not any(message.data for message in paused)
    assert commanders(peer, '/tb3_1/cmd_vel') == sources
    assert first.end() == 130
