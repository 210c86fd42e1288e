import pytest

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry

from setcmas_simu.errors import SetcmasError
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.simulator_watch import SimulatorWatch, refuse_second_simulator


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
    refuse_second_simulator(node, [1, 2, 3, 4], is_stopping=lambda: True)  # it ends anyway


def test_a_second_publisher_is_reported_once_when_it_stays(peer, node, capfd):
    def reported():
        return 'the odometry of robot 2 has two publishers' in capfd.readouterr().err

    for robot in (1, 2):
        node.create_publisher(Odometry, f'/tb3_{robot}/odom', 1)
    watch = SimulatorWatch(node, [1, 2], 'twist_stamped')
    watch.warn_of_others()
    watch.warn_of_others()
    assert not reported()

    other = peer.node.create_publisher(Odometry, '/a/tb3_2/odom', 1)
    peer.wait_for(lambda: node.count_publishers('/tb3_2/odom') == 2)
    watch.warn_of_others()
    assert not reported()  # it may be about to refuse to start
    watch.warn_of_others()
    assert reported()
    watch.warn_of_others()
    assert not reported()
    peer.node.destroy_publisher(other)
