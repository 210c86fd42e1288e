import pytest

pytest.importorskip('rclpy')

import rclpy
from geometry_msgs.msg import TwistStamped

from setcmas_simu.ros.cmd_vel_topics import CmdVelPublisher, own_participant
from setcmas_simu.ros.fleet_node import FleetNode


def test_a_node_of_another_name_is_no_rival_of_itself(domain, peer):
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    arguments = ['--ros-args', '-r', '__node:=mine']
    node = FleetNode('controllers', context=context, cli_args=arguments)
    cmd_vel = CmdVelPublisher(node, 1, '/tb3_1/cmd_vel', '/tb3_1/odom')
    own = own_participant(node)
    assert cmd_vel.other_commanders(own) == []

    peer.node.create_publisher(TwistStamped, '/tb3_1/cmd_vel', 1)
    peer.wait_for(lambda: cmd_vel.other_commanders(own) == ['/peer'])
    node.destroy_node()
    rclpy.try_shutdown(context=context)
