import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import TwistStamped

from setcmas_simu.ros.cmd_vel_topics import CmdVelPublisher, rivals
from setcmas_simu.ros.fleet_node import FleetNode


def test_a_node_of_another_name_is_no_rival_of_itself(peer):
    arguments = ['--ros-args', '-r', '__node:=mine']
    node = peer.add(FleetNode('controllers', context=peer.context, cli_args=arguments))
    cmd_vel = CmdVelPublisher(node, 1, '/tb3_1/cmd_vel', '/tb3_1/odom')
    own = node.get_fully_qualified_name()
    assert rivals(node, cmd_vel.topic, own) == []

    peer.node.create_publisher(TwistStamped, '/tb3_1/cmd_vel', 1)
    peer.wait_for(lambda: rivals(node, cmd_vel.topic, own) == ['/peer'])
