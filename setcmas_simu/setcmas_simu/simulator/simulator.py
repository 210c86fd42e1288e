"""The simulator process: a fleet of virtual robots.

Start it with `ros2 run setcmas_simu virtual_robot --robots 1-4`, or for one robot by parameters:
`--ros-args -p robot_no:=3 -p x0:=1.0 -p limits:=burger`.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

from rclpy.node import Node

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.announcement import Announcement, Lockstep
from setcmas_simu.robots.models import seed_scripts
from setcmas_simu.ros.cmd_vel_topics import UnreadCommands
from setcmas_simu.ros.fleet_topic import FleetAnnouncer
from setcmas_simu.ros.parameters import ProcessParameters, declare_fixed, fixed_in_lockstep
from setcmas_simu.ros.process import FleetNode, RosProcess, end_process, node_main
from setcmas_simu.ros.step_loop import ScaledClock, StepLoop
from setcmas_simu.simulator.duplicate_simulators import (
    SecondPublishers,
    refuse_second_simulator,
)
from setcmas_simu.simulator.fleet_stepper import FleetStepper
from setcmas_simu.simulator.lockstep_simulator import LockstepLoop
from setcmas_simu.simulator.lockstep_topics import ClockTopic
from setcmas_simu.simulator.simulator_options import (
    SimulatedRobots,
    SimulationOptions,
    SimulatorOptions,
)
from setcmas_simu.simulator.virtual_robot import VirtualRobot

FIXED = ('rtf', 'cmd_vel_type')
"""Parameters that cannot be set while the simulator runs."""

PARAMETERS = {
    'rate': 'robot_rate',
    **{name: name for name in ('limits', 'cmd_timeout', *FIXED)},
}
"""The options that are parameters of the process's node, by parameter name."""


def robot_of_parameters(node: Node) -> int:
    """Return the robot in `--ros-args -p robot_no:=N`; 1 without it."""
    robot: object = declare_fixed(node, 'robot_no', 1, 'number of the robot')
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
    node = FleetNode(topics.VIRTUAL_ROBOTS, enable_rosout=True)
    alone = options.robots is None and options.nb_robots is None
    if alone:
        options = replace(options, robots=(robot_of_parameters(node),))
    parameters = ProcessParameters(node, options, PARAMETERS, FIXED)
    options = parameters.options
    simulated = options.simulated()
    refuse_second_simulator(node, simulated.robots)
    announcer = FleetAnnouncer(node)
    seed_scripts(simulated.models, options.seed)
    robots = _virtual_robots(node, simulated, options, alone)
    parameters.warn_of_unknown()
    stepper = FleetStepper(node, robots, options)
    stepper.on_failure = process.launcher.report
    process.add(node)
    others = SecondPublishers(node, simulated.robots)
    unread = UnreadCommands(node, simulated.robots, options.cmd_vel_type, options.lockstep)

    def look_around() -> None:
        others.look()
        unread.look()

    stepper.housekeeping = look_around
    stepper.log_robots()
    models = tuple(robot.model for robot in robots)
    loop: LockstepLoop | StepLoop
    begin, lockstep = 0.0, None
    if options.lockstep:
        ending = SimulatorOptions.of(args)
        loop = LockstepLoop(process, node, stepper, robots, ending)
        lockstep = Lockstep(stepper.rate, ending.nb_steps)
    elif options.rtf != 1.0:
        clock = ScaledClock(options.rtf)
        loop = StepLoop(process, stepper.period, stepper.step, clock)
        begin = clock.begin
    else:
        loop = StepLoop(process, stepper.period, stepper.step)
    if options.lockstep or options.rtf != 1.0:
        stepper.publish_time = ClockTopic(node, options.lockstep).publish
    announcer.announce(
        Announcement(
            options.fleet_size,
            tuple(simulated.robots),
            models,
            options.limits,
            options.rtf,
            begin,
            lockstep,
        )
    )
    process.launcher.report_ready()
    parameters.check = fixed_in_lockstep if options.lockstep else stepper.check

    def follow(options: SimulationOptions) -> None:
        stepper.follow(options)
        if isinstance(loop, StepLoop):
            loop.period = stepper.period

    parameters.on_change = follow
    loop.run()


def _virtual_robots(
    node: Node, simulated: SimulatedRobots, options: SimulationOptions, alone: bool
) -> list[VirtualRobot]:
    world = declare_fixed(node, 'world_frame', topics.WORLD_FRAME, 'frame of poses')
    poses = simulated.start_poses.T.tolist()
    robots = []
    for robot, model, (x0, y0, theta0) in zip(
        simulated.robots, simulated.models, poses, strict=True
    ):
        start = {'x0': x0, 'y0': y0, 'theta0': theta0, 'model': model}
        start |= {'world_frame': world, 'robot_frame': topics.robot_frame(robot)}
        prefix = '' if alone else f'{topics.robot_name(robot)}.'
        robots.append(
            VirtualRobot(node, robot, start, options.cmd_vel_type, options.lockstep, prefix)
        )
    return robots


if __name__ == '__main__':
    end_process(main())
