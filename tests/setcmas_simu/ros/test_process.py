import os
import subprocess
import sys

import pytest

pytest.importorskip('rclpy')

from std_msgs.msg import String

from setcmas_simu.errors import SetcmasError
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.process import prefer_this_process

HANGS = """
import ctypes
from setcmas_simu.ros.process import ros_process

with ros_process() as process:
    process.status = 3
    process.executor.shutdown = lambda: ctypes.PyDLL(None).sleep(600)  # with Python's lock
"""


def test_a_process_ends_whose_ros_never_does(domain):
    process = subprocess.run([sys.executable, '-c', HANGS], timeout=120, check=False)

    assert process.returncode == 3


def test_a_system_that_forbids_a_higher_priority_is_obeyed(monkeypatch):
    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr(os, 'setpriority', refuse)
    prefer_this_process()


@pytest.fixture
def node_in(peer):
    def node_in(*arguments, **settings):
        arguments = ['--ros-args', *arguments]
        return peer.add(FleetNode('node', context=peer.context, cli_args=arguments, **settings))

    return node_in


LEAVES = """
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.process import ros_process

with ros_process():
    node = FleetNode('node')
try:
    node.get_name()
except Exception as error:
    print(type(error).__name__)
"""


def test_a_process_leaves_the_graph_at_its_end(domain):
    printed = subprocess.check_output([sys.executable, '-c', LEAVES], timeout=120, text=True)
    assert printed == 'InvalidHandle\n'  # others would see it for seconds


def test_a_namespace_is_the_root_of_all_topics_but_those_of_ros(node_in, peer):
    node = node_in('-r', '__ns:=/a')
    for name in ('/fleet', '/tb3_1/odom'):
        node.create_publisher(String, name, 1)
    peer.node.create_publisher(String, '/tb3_2/odom', 1)

    published = {name for name, _ in peer.node.get_topic_names_and_types()}
    assert {'/a/fleet', '/a/tb3_1/odom', '/rosout', '/parameter_events'} <= published
    seen = {name for name, _ in node.get_topic_names_and_types()}
    assert seen == {'/fleet', '/tb3_1/odom', '/rosout', '/parameter_events'}
    assert node.count_publishers('/tb3_1/odom') == node.count_publishers('/a/tb3_1/odom') == 1
    (found,) = node.get_publishers_info_by_topic('/tb3_1/odom')
    assert found.node_namespace == '/a'


def test_a_fleet_within_the_namespace_is_another_one(node_in):
    inner = node_in('-r', '__ns:=/a')
    for name in ('/fleet', '/tb3_1/odom'):
        inner.create_publisher(String, name, 1)
    outer = node_in()
    outer.create_publisher(String, '/mocap/tb3_1/odom', 1)

    seen = {name for name, _ in outer.get_topic_names_and_types()}
    assert '/mocap/tb3_1/odom' in seen
    assert not [name for name in seen if name.startswith('/a/')]


def test_simulated_time_is_refused_by_nodes_that_do_not_follow_it(node_in):
    with pytest.raises(SetcmasError, match='node refuses use_sim_time'):
        node_in('-p', 'use_sim_time:=true')

    node = node_in('-p', 'use_sim_time:=true', follows_clock=True)
    assert node.describe_parameter('use_sim_time').read_only
