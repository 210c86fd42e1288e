import os
import subprocess
import sys

import pytest

pytest.importorskip('rclpy')

from setcmas_simu.ros.dds_setup import is_loopback_enough

USES_SHARED_MEMORY = """
import os
from setcmas_simu.ros.process import FleetNode, ros_process
with ros_process() as process:
    node = FleetNode('node')
    with open('/proc/self/maps') as maps:
        print('/dev/shm/fastrtps' in maps.read(), os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'])
"""


@pytest.mark.parametrize('reach', ['LOCALHOST', 'SUBNET'])
@pytest.mark.parametrize(
    ('chosen', 'shared'), [({}, False), ({'FASTDDS_BUILTIN_TRANSPORTS': 'DEFAULT'}, True)]
)
def test_nodes_share_no_memory_unless_the_user_has_chosen_it(domain, reach, chosen, shared):
    environment = {**os.environ, 'ROS_AUTOMATIC_DISCOVERY_RANGE': reach, **chosen}
    node = subprocess.run(
        [sys.executable, '-c', USES_SHARED_MEMORY],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )

    assert node.stdout == f'{shared} {reach}\n'


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
