import os
import subprocess
import sys

import pytest

pytest.importorskip('rclpy')

from network_namespaces import Network, NoNetworkError
from processes import TIMEOUT_S

from setcmas_simu.ros.dds_setup import is_loopback_enough

USES_SHARED_MEMORY = """
import os
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.process import ros_process
with ros_process() as process:
    node = FleetNode('node')
    with open('/proc/self/maps') as maps:
        print('/dev/shm/fastrtps' in maps.read(), os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'])
"""

ARRIVES_AT_ONCE = """
from geometry_msgs.msg import Point32
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.process import ros_process
with ros_process():
    sender, receiver = FleetNode('sender'), FleetNode('receiver')
    publisher = sender.create_publisher(Point32, 'cmd_cart_vel', qos.COMMAND)
    take = receiver.newest(Point32, 'cmd_cart_vel', qos.COMMAND)
    while not publisher.get_subscription_count():
        pass
    arrived = 0
    for i in range(500):
        publisher.publish(Point32(x=float(i)))
        message = take()
        arrived += bool(message and message.x == i)
    print(arrived)
"""

MEET = f"""
import sys
import time
import rclpy
from setcmas_simu.ros.dds_setup import dds_setup
from setcmas_simu.ros.fleet_node import FleetNode
host, own, all_there = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
with dds_setup():
    contexts = [rclpy.Context() for _ in range(own)]
    for context in contexts:
        rclpy.init(context=context)
nodes = [FleetNode(f'{{host}}_{{i}}', context=c) for i, c in enumerate(contexts)]
end = time.monotonic() + {TIMEOUT_S}
while (seen := [len(set(node.get_node_names())) for node in nodes]) != [all_there] * own:
    if time.monotonic() > end:
        break
    time.sleep(0.02)
print(seen, flush=True)
sys.stdin.read()
"""


def printed(code, environment):
    """Return what code prints in a process of its own with some more of an environment."""
    command = [sys.executable, '-c', code]
    return subprocess.check_output(command, env={**os.environ, **environment}, text=True)


@pytest.mark.parametrize('reach', ['LOCALHOST', 'SUBNET'])
@pytest.mark.parametrize(
    ('chosen', 'shared'), [({}, False), ({'FASTDDS_BUILTIN_TRANSPORTS': 'DEFAULT'}, True)]
)
def test_nodes_share_no_memory_unless_the_user_has_chosen_it(domain, reach, chosen, shared):
    environment = {'ROS_AUTOMATIC_DISCOVERY_RANGE': reach, **chosen}

    assert printed(USES_SHARED_MEMORY, environment) == f'{shared} {reach}\n'


def test_messages_reach_nodes_of_the_same_process_at_once(domain):
    assert printed(ARRIVES_AT_ONCE, {'RMW_FASTRTPS_PUBLICATION_MODE': 'ASYNCHRONOUS'}) == '500\n'


@pytest.mark.parametrize(
    ('variables', 'enough'),
    [
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}, True),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}, False),
        ({}, False),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_STATIC_PEERS': '10.0.0.2'}, False),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_STATIC_PEERS': ''}, True),
    ],
)
def test_loopback_is_enough_if_nothing_leads_to_other_machines(variables, enough):
    assert is_loopback_enough(variables) == enough


def test_static_peers_meet_however_many_processes_each_machine_has(domain):
    numbers = 6, 12  # of a machine, and in all; Fast DDS by itself asks the first four
    try:
        with Network('left', 'right') as network:
            machines = [
                subprocess.Popen(
                    network.command(name, [sys.executable, '-c', MEET, name, *map(str, numbers)]),
                    env={
                        **os.environ,
                        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET',
                        'ROS_STATIC_PEERS': ';'.join(network.addresses.values()),
                    },
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    text=True,
                )
                for name in network.addresses
            ]
            seen = [machine.stdout.readline() for machine in machines]
            for machine in machines:
                machine.communicate()
    except NoNetworkError as error:
        pytest.skip(str(error))

    assert seen == [f'{[12] * 6}\n'] * 2
