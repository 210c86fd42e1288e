"""Injects a fault into an emulated lab."""

from __future__ import annotations

import os

from rclpy.duration import Duration
from std_msgs.msg import String

from setcmas_expe.emulation.faults import Fault
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import FleetNode, ros_process

_DISCOVERY_S = 3.0
_SENDING_S = 2.0


def inject(fault: Fault) -> None:
    """Send a fault to the emulated lab in this ROS domain, or raise SetcmasError."""
    with ros_process() as process:
        node = FleetNode('inject_fault')
        process.add(node)
        publisher = node.create_publisher(String, topics.EMULATED_FAULT, qos.EVENT)
        if not process.spin_until(lambda: publisher.get_subscription_count() > 0, _DISCOVERY_S):
            raise SetcmasError(
                f'there is no emulated lab in ROS domain {os.environ.get("ROS_DOMAIN_ID", "0")}: '
                'start one with setcmas expe --emulate'
            )
        publisher.publish(String(data=str(fault)))
        publisher.wait_for_all_acked(Duration(seconds=_SENDING_S))
