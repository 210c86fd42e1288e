"""Zero commander: commands zero velocity, in place of a controller that hangs or has died.

The launcher starts it as `ros2 run setcmas_ctrl zero_commander --robots 1-8`; the launch file of
controllers does so, too.
"""

from __future__ import annotations

import argparse
import sys

from setcmas_ctrl.driving.fleet_discovery import robots_with_odometry
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import parse_robots
from setcmas_simu.ros.cmd_vel_topics import CmdVelPublisher
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main

_LISTENERS_WAIT_S = 2.0
_REPEATS_S = 0.5


def main(argv: list[str] | None = None) -> int:
    """Command zero velocity; return the exit status."""
    parser = argparse.ArgumentParser(prog='zero_commander', description=__doc__)
    parser.add_argument('--robots', metavar='LIST', help='such as 1-4 (default: the whole fleet)')
    return node_main(parser, _stop_robots, argv)


def _stop_robots(process: RosProcess, args: argparse.Namespace) -> None:
    node = FleetNode(topics.ZERO_COMMANDER_NODE)
    process.add(node)
    robots = parse_robots(args.robots) if args.robots else _fleet(process, node)
    cmd_vels = [
        CmdVelPublisher(
            node,
            robot,
            topics.robot_topic(robot, topics.CMD_VEL),
            topics.odometry_topic(robot),
        )
        for robot in robots
    ]
    process.spin_until(lambda: _all_connected(cmd_vels), _LISTENERS_WAIT_S)

    def stop() -> bool:
        for cmd_vel in cmd_vels:
            cmd_vel.publish(0.0, 0.0)
        return False

    # A listener is in the graph shortly before messages reach it.
    process.spin_until(stop, _REPEATS_S, every_s=0.05)
    for cmd_vel in cmd_vels:
        cmd_vel.wait_until_sent()


def _fleet(process: RosProcess, node: FleetNode) -> list[int]:
    """Return the robots that are announced, or else those with odometry."""
    listener = FleetListener(node)

    def is_announced() -> bool:
        listener.take()
        return listener.is_complete

    process.spin_until(is_announced, _LISTENERS_WAIT_S)
    return listener.robots or robots_with_odometry(node)


def _all_connected(cmd_vels: list[CmdVelPublisher]) -> bool:
    """Match the type of each listener; return whether every robot listens."""
    unconnected = [cmd_vel for cmd_vel in cmd_vels if not cmd_vel.follow_listeners()]
    return not unconnected


if __name__ == '__main__':
    sys.exit(main())
