"""Bridge process of an experiment: motion capture in, commands to real robots out.

Run as `ros2 run setcmas_expe bridges --lab lab.yaml`; `setcmas expe` does it for you.
"""

from __future__ import annotations

import argparse
import sys

from setcmas_expe.lab.model import Lab
from setcmas_expe.lab.options import LabOptions
from setcmas_expe.plausibility.options import ProofOptions
from setcmas_expe.safety.cmd_vel_bridge import CmdVelBridge
from setcmas_expe.safety.decision import RATE_HZ
from setcmas_expe.safety.mocap_bridge import MocapBridge
from setcmas_expe.safety.reporting.arena_markers import publish_arena
from setcmas_expe.safety.stepper import SafetyStepper
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.announcement import Kind
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.messages.fleet_topic import FleetAnnouncer
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main
from setcmas_simu.ros.step_loop import StepLoop


def _greet(node: FleetNode, lab: Lab) -> None:
    robots = robots_in_words([robot.number for robot in lab.robots])
    arena, source = lab.arena, lab.mocap.topic_of(lab.robots[0])
    node.get_logger().info(
        f'bridging {robots}: poses from {source} ({lab.mocap.preset}), '
        f'arena {arena.xmin:g} to {arena.xmax:g} by {arena.ymin:g} to {arena.ymax:g} m, '
        f'up to {lab.limits.V_max:.2f} m/s'
    )


def main(argv: list[str] | None = None) -> int:
    """Bridge until a signal arrives; returns the exit status."""
    parser = argparse.ArgumentParser(prog='bridges', description=__doc__)
    LabOptions.add_to(parser)
    ProofOptions.add_to(parser)
    return node_main(parser, _bridge, argv)


def _bridge(process: RosProcess, args: argparse.Namespace) -> None:
    lab = LabOptions.of(args).chosen()
    node = FleetNode(topics.BRIDGES_NODE)
    announcer = FleetAnnouncer(node, Kind.LAB)
    mocaps = [MocapBridge(robot, lab) for robot in lab.robots]
    bridges = [CmdVelBridge(robot, lab) for robot in lab.robots]
    process.add(node, *mocaps, *bridges)
    publish_arena(node, lab)
    stepper = SafetyStepper(node, lab, mocaps, bridges, ProofOptions.of(args).proofs(lab))
    _greet(node, lab)
    try:
        announcer.announce([robot.number for robot in lab.robots], lab.nb_robots)
        # Motion capture is called back in between: when a pose comes tells how fast it moves.
        StepLoop(process, 1.0 / RATE_HZ, stepper.step).run()
    finally:  # whatever happens in a callback, robots get their zero
        stepper.stop()


if __name__ == '__main__':
    sys.exit(main())
