"""Injects a fault into an emulated lab.

Run as `ros2 run setcmas_expe inject_fault dropout 2 3.0`.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys

from rclpy.duration import Duration
from std_msgs.msg import String

from setcmas_expe.emulation.faults import DEFAULT_S, PURPOSES, parse_fault
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main

_DISCOVERY_S = 3.0
_SENDING_S = 2.0
_LONGEST_S = 60  # for the whole command, in case the lab ends meanwhile


def _inject(process: RosProcess, args: argparse.Namespace) -> None:
    process.launcher.mistake = 'setcmas fault'
    process.end_within(_LONGEST_S)
    fault = parse_fault(f'{args.kind} {args.robot} {args.seconds}')
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


def main(argv: list[str] | None = None) -> int:
    """Inject a fault; return the exit status."""
    parser = argparse.ArgumentParser(prog='inject_fault', description=__doc__)
    parser.add_argument('kind', choices=list(PURPOSES))
    parser.add_argument('robot')
    parser.add_argument('seconds', nargs='?', default=f'{DEFAULT_S}')
    signal.alarm(_LONGEST_S)  # in case ROS never starts
    return node_main(parser, _inject, argv)


if __name__ == '__main__':
    sys.exit(main())
