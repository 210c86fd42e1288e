"""The simulator process: a fleet of virtual robots.

Start it with `ros2 run setcmas_simu virtual_robot --robots 1-4`, or for one robot by parameters:
`--ros-args -p robot_no:=3 -p x0:=1.0 -p limits:=burger`.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace

from rclpy.qos import QoSProfile

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.announcement import Kind, Lockstep, Scaled, SimulatedTime
from setcmas_simu.robots.models import seed_scripts
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_topic import FleetAnnouncer
from setcmas_simu.ros.parameters import ProcessParameters, fixed_in_lockstep
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main
from setcmas_simu.ros.step_loop import ScaledClock, StepLoop
from setcmas_simu.simulator.duplicate_simulators import DuplicateSimulators
from setcmas_simu.simulator.fleet_stepper import FleetStepper
from setcmas_simu.simulator.lockstep_simulator import LockstepLoop
from setcmas_simu.simulator.lockstep_topics import ClockTopic
from setcmas_simu.simulator.simulator_options import (
    SimulatedRobots,
    SimulationOptions,
    SimulatorOptions,
)
from setcmas_simu.simulator.virtual_robot import VirtualRobot

PARAMETERS = {'rate': 'robot_rate', 'limits': 'limits', 'cmd_timeout': 'cmd_timeout', 'rtf': 'rtf'}
"""The options that are parameters of the process's node, by parameter name."""


def robot_of_parameters() -> int:
    """Return the robot in `--ros-args -p robot_no:=N`; 1 without it."""
    probe = FleetNode('virtual_robot', automatically_declare_parameters_from_overrides=True)
    robot = probe.get_parameter('robot_no').value if probe.has_parameter('robot_no') else 1
    probe.destroy_node()
    if not isinstance(robot, int) or robot < 1:
        raise SetcmasError(f'parameter robot_no is {robot!r}; it must be a whole number from 1')
    return robot


def main(argv: list[str] | None = None) -> int:
    """Simulate robots until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='virtual_robot', description=__doc__)
    SimulationOptions.add_to(parser)
    SimulatorOptions.add_to(parser)
    return node_main(parser, _simulate, argv)


def _simulate(process: RosProcess, args: argparse.Namespace) -> None:
    options = SimulationOptions.of(args)
    if options.robots is None and options.nb_robots is None:
        options = replace(options, robots=(robot_of_parameters(),))
    simulated = options.simulated()
    node = FleetNode.of_process(f'{topics.VIRTUAL_ROBOT_NODE}s')
    parameters = ProcessParameters(node, options, PARAMETERS)
    options = parameters.options
    announcer = FleetAnnouncer(node, Kind.SIMULATOR)
    guard = DuplicateSimulators(node, simulated.robots)
    seed_scripts(simulated.models, options.seed)
    profile = qos.LOCKSTEP_STATE if options.lockstep else qos.STATE
    nodes = _virtual_robots(simulated, options, profile)
    parameters.warn_of_unknown(*nodes)
    stepper = FleetStepper(node, nodes, options.rtf)
    stepper.on_failure = process.launcher.report
    guard.refuse_second_simulator()
    process.add(node)
    stepper.housekeeping = guard.warn_of_latecomers
    stepper.log_robots()
    models = [str(robot.value('model')) for robot in nodes]
    loop: LockstepLoop | StepLoop
    time: SimulatedTime | None = None
    if options.lockstep:
        ending = SimulatorOptions.of(args)
        loop = LockstepLoop(process, node, stepper, nodes, ending)
        time = Lockstep(stepper.rate, ending.nb_steps)
    elif options.rtf != 1.0:
        clock = ScaledClock(options.rtf)
        loop = StepLoop(process, stepper.period, stepper.step, clock)
        time = Scaled(options.rtf, clock.begin)
    else:
        loop = StepLoop(process, stepper.period, stepper.step)
    if time:
        stepper.publish_time = ClockTopic(node).publish
    announcer.announce(simulated.robots, options.fleet_size, models, time)
    process.launcher.report_ready()
    parameters.check = fixed_in_lockstep if options.lockstep else stepper.check

    def follow(options: SimulationOptions) -> None:
        stepper.follow(options)
        if isinstance(loop, StepLoop):
            loop.period = stepper.period

    parameters.on_change = follow
    loop.run()


def _virtual_robots(
    simulated: SimulatedRobots, options: SimulationOptions, profile: QoSProfile
) -> list[VirtualRobot]:
    common = {
        'rate': options.robot_rate,
        'limits': options.limits,
        'cmd_timeout': options.cmd_timeout,
        'cmd_vel_type': options.cmd_vel_type,
    }
    poses = simulated.start_poses.T.tolist()
    own = zip(simulated.robots, simulated.models, poses, strict=True)
    return [
        VirtualRobot(
            robot, {'x0': x0, 'y0': y0, 'theta0': theta0, 'model': model} | common, profile
        )
        for robot, model, (x0, y0, theta0) in own
    ]


if __name__ == '__main__':
    sys.exit(main())
