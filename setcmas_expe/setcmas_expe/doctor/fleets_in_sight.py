"""Other fleets in the same ROS domain."""

from __future__ import annotations

from collections import defaultdict

from rclpy.node import Node

from setcmas_expe.doctor.findings import NOTE, OK, Finding
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros.fleet_topic import FleetListener

_WHAT = 'other fleets'


def fleets_finding(node: Node, announced: FleetListener) -> Finding:
    """Return the robots in sight: announced ones, and others by the sender of their odometry."""
    fleets = {str(one.source): set(one.robots) for one in announced.take().values()}
    for sender, robots in _by_odometry(node).items():
        if others := robots.difference(*fleets.values()):
            fleets[sender] = others
    if not fleets:
        return Finding(OK, _WHAT, 'none in sight in this ROS domain')
    found = '; '.join(
        f'{robots_in_words(sorted(robots))} of {sender}' for sender, robots in fleets.items()
    )
    advice = (
        'if they are not yours, set another ROS_DOMAIN_ID (0 to 101), the same on your machines '
        'and robots'
    )
    return Finding(NOTE, _WHAT, found, advice)


def _by_odometry(node: Node) -> dict[str, set[int]]:
    senders: defaultdict[str, set[int]] = defaultdict(set)
    for name, _ in node.get_topic_names_and_types():
        robot = topics.robot_of(name)
        if robot and name == topics.robot_topic(robot, topics.ODOM):
            for info in node.get_publishers_info_by_topic(name):
                senders[info.node_name].add(robot)
    return senders
