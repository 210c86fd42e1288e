import subprocess
import sys

import pytest

from launch_scripts import environment
from setcmas_simu.errors import SetcmasError


def test_topics_stay_on_this_machine_unless_the_user_decides_otherwise(monkeypatch):
    monkeypatch.delenv('ROS_AUTOMATIC_DISCOVERY_RANGE', raising=False)
    assert environment.local_environment()['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'LOCALHOST'

    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
    assert environment.local_environment()['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'SUBNET'


def test_without_ros_a_verb_says_what_to_install(monkeypatch):
    monkeypatch.setattr(environment.importlib.util, 'find_spec', lambda _: None)

    with pytest.raises(SetcmasError, match=r"ROS 2 Jazzy is needed.*pip install 'ros-jazzy"):
        environment.require_ros()


def test_nodes_run_with_this_interpreter():
    command = environment.node_command('some.module', ['--option', 'value'])

    assert command[0] == sys.executable
    assert command[-3:] == ['some.module', '--option', 'value']


def test_an_empty_entry_of_pythonpath_is_left_out(monkeypatch):
    monkeypatch.setenv('PYTHONPATH', ':/somewhere:.')

    assert environment.local_environment()['PYTHONPATH'] == '/somewhere'


def test_where_signals_are_missing_the_commands_can_be_imported():
    code = (
        'import enum, signal\n'
        'gone = ("SIGHUP", "SIGKILL", "SIGTSTP")\n'
        'names = [s.name for s in signal.Signals if s.name not in gone]\n'
        'signal.Signals = enum.IntEnum("Signals", {n: int(signal.Signals[n]) for n in names})\n'
        'del signal.SIGHUP, signal.SIGKILL, signal.SIGTSTP\n'
        'from launch_scripts.cli import build_parser\nbuild_parser(None)'
    )

    subprocess.run([sys.executable, '-c', code], check=True)


@pytest.mark.parametrize('domain', ['abc', '-1', '300', '1.5'])
def test_a_domain_that_is_none_is_refused(monkeypatch, domain):
    monkeypatch.setattr(environment.importlib.util, 'find_spec', lambda _: True)
    monkeypatch.setenv('ROS_DOMAIN_ID', domain)

    with pytest.raises(SetcmasError, match=f"ROS_DOMAIN_ID is '{domain}'; accepted are 0 to 101"):
        environment.require_ros()
