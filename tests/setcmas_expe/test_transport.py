import os
import subprocess
import sys

import pytest

from setcmas_expe.transport import use_udp_alone

SHARED = """
from setcmas_simu.nodes.ros_process import FleetNode, ros_process
with ros_process() as process:
    node = FleetNode('node')
    with open('/proc/self/maps') as maps:
        print('/dev/shm/fastrtps' in maps.read())
"""


def test_what_the_user_has_chosen_stays():
    environment = {'FASTDDS_BUILTIN_TRANSPORTS': 'DEFAULT'}
    use_udp_alone(environment)

    assert environment == {'FASTDDS_BUILTIN_TRANSPORTS': 'DEFAULT'}


def test_a_node_on_a_network_has_no_queue_in_shared_memory(domain):
    pytest.importorskip('rclpy')
    environment = os.environ | {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}
    use_udp_alone(environment)
    node = subprocess.run(
        [sys.executable, '-c', SHARED], env=environment, capture_output=True, text=True, check=True
    )

    assert node.stdout == 'False\n'
