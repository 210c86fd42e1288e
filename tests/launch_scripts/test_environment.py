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

    with pytest.raises(SetcmasError, match=r"setcmas simu needs ROS 2.*pip install 'ros-jazzy"):
        environment.require_ros('simu')


def test_nodes_run_with_this_interpreter():
    command = environment.node_command('some.module', ['--option', 'value'])

    assert command[0] == sys.executable
    assert command[-3:] == ['some.module', '--option', 'value']
