import pytest

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry

from setcmas_simu.errors import SetcmasError
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.simulator_watch import refuse_second_simulator


@pytest.fixture
def node(peer):
    return FleetNode('simulator', context=peer.context, namespace='/a')


def test_robots_of_others_are_refused_with_their_node_and_the_domain(peer, node, domain):
    for robot in (2, 3, 5):
        peer.node.create_publisher(Odometry, f'/a/tb3_{robot}/odom', 1)
    peer.node.create_publisher(Odometry, '/tb3_1/odom', 1)  # of another fleet

    refuse_second_simulator(node, [1, 4])
    message = f'robots 2-3 are already simulated in ROS domain {domain} .node /peer publishes'
    with pytest.raises(SetcmasError, match=message):
        refuse_second_simulator(node, [1, 2, 3, 4])
