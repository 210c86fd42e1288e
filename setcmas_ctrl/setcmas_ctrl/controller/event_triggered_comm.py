"""Event-triggered broadcast: sends a robot's state when a condition triggers.

With --event-triggered, a controller process holds such a node for each of its robots. To start it
alone: `ros2 run setcmas_ctrl event_triggered_comm --robots 1-2 --ctc my_condition`.
"""

from __future__ import annotations

import argparse
import contextlib
import time
from collections.abc import Callable
from pathlib import Path

from nav_msgs.msg import Odometry
from std_msgs.msg import UInt16

from setcmas_ctrl.communication.communication_settings import (
    Communication,
    CommunicationOptions,
    chosen_communication,
)
from setcmas_ctrl.communication.triggering import CONSEQUENCE, CTC, Broadcast
from setcmas_ctrl.control.control_options import SCRIPT_FAILED
from setcmas_ctrl.controller.script_outcomes import end_process, end_stuck_script
from setcmas_ctrl.driving.odometry import FleetOdometry, Pose, State
from setcmas_ctrl.scripts.call_watch import CallWatch
from setcmas_ctrl.scripts.output import named_output
from setcmas_ctrl.scripts.script_errors import AbandonCall, ErrorReports, StopCall
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import parse_robots, robots_in_words
from setcmas_simu.reports.script_calls import Function
from setcmas_simu.robots.unicycle import RATE_HZ as ROBOT_RATE_HZ
from setcmas_simu.ros import qos
from setcmas_simu.ros.messages import NO_STAMP, read_stamp
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main
from setcmas_simu.ros.step_loop import StepLoop

_LOOK_EVERY_S = 0.01


class EventTriggeredComm(FleetNode):
    """Broadcasts the state of one robot when its condition triggers, and publishes each decision.

    Attributes:
        robot: Number of the robot.
        sent: Stamp of the last state sent in ns; NO_STAMP if none was sent.
    """

    def __init__(
        self,
        broadcast: Broadcast,
        clock: Callable[[], float],
        watch: CallWatch,
        lockstep: bool = False,
    ) -> None:
        """Create the node in the robot's namespace; `clock` returns the time t of the run in s.

        In lockstep, late recorders still get everything.
        """
        super().__init__('event_triggered_comm', namespace=topics.robot_name(broadcast.robot))
        self.robot = broadcast.robot
        self.sent = NO_STAMP
        self._broadcast = broadcast
        self._now = clock
        self._watch = watch
        events, states = (qos.LOCKSTEP_STATE,) * 2 if lockstep else (qos.EVENT, qos.LATCHED)
        self._events = self.create_publisher(UInt16, topics.TRIG_EVENT, events)
        # Latched: late subscribers get the last state sent.
        self._states = self.create_publisher(Odometry, topics.TRIG_ODOM, states)

    def take(self, state: State) -> None:
        """Decide whether to send a state."""
        triggered = self._is_triggered(state.pose, state.V)
        self._events.publish(UInt16(data=int(triggered)))
        if triggered:
            self.sent = read_stamp(state.odometry)
            self._states.publish(state.odometry)

    def _is_triggered(self, pose: Pose, V: float) -> bool:
        t = self._now()
        one = self._broadcast
        try:
            with self._watch.call(one.robot, one.path, Function.CONDITION):
                return one.is_triggered(pose, V, t)
        except AbandonCall:  # a new control law was saved; the condition stays
            return True
        except KeyboardInterrupt as error:  # signals raise StopCall, so the script raised this
            return one.failed(error, t)


def broadcasters(
    robots: list[int],
    communication: Communication,
    odometry: FleetOdometry,
    reports: ErrorReports,
    clock: Callable[[], float],
    watch: CallWatch,
    lockstep: bool = False,
) -> list[EventTriggeredComm]:
    """Return a broadcasting node for each robot.

    Raises:
        SetcmasError: A triggering condition does not load.
    """
    nodes = []
    path = communication.condition_script or Path(CTC)
    for robot in robots:
        with watch.loading(robot, path):
            broadcast = communication.broadcast(robot, reports)
        node = EventTriggeredComm(broadcast, clock, watch, lockstep)
        odometry.listen(robot, node.take)
        nodes.append(node)
    return nodes


def main(argv: list[str] | None = None) -> int:
    """Broadcast until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='event_triggered_comm', description=__doc__)
    parser.add_argument('--robots', default='1', metavar='LIST', help='such as 1-4 (default: 1)')
    parser.add_argument('--ctc', metavar='FILE', help='script with ctc(pos, last_pos, t)')
    parser.add_argument(
        '--odometry-topic',
        default=f'/{{name}}/{topics.ODOM}',
        metavar='TOPIC',
        help='topic of the states; {name} is the robot (default: %(default)s)',
    )
    return node_main(parser, _serve, argv)


def _serve(process: RosProcess, args: argparse.Namespace) -> int:
    with named_output():
        node = FleetNode('broadcasters')
        reports = ErrorReports(node.get_logger().warning, CONSEQUENCE)
        with contextlib.suppress(StopCall):  # a signal ended a stuck call
            _broadcast(args, process, node, reports)
    return SCRIPT_FAILED if reports.failed_robots else 0


def _broadcast(
    args: argparse.Namespace, process: RosProcess, node: FleetNode, reports: ErrorReports
) -> None:
    robots = parse_robots(args.robots)
    chosen = chosen_communication(
        robots[-1], CommunicationOptions(event_triggered=True, ctc=args.ctc)
    )
    odometry = FleetOdometry(
        node,
        robots[-1],
        lambda robot: args.odometry_topic.replace('{name}', topics.robot_name(robot)),
        robots,
    )
    watch = CallWatch(1 / ROBOT_RATE_HZ, node.get_logger().warning, process.launcher)
    end_stuck_script(process, watch)
    begin = time.monotonic()
    broadcasters(robots, chosen, odometry, reports, lambda: time.monotonic() - begin, watch)
    process.take_signals()  # scripts may have changed the handlers while loading
    process.add(node)
    node.get_logger().info(f'broadcasting for {robots_in_words(robots)}; Ctrl-C stops')
    StepLoop(process, _LOOK_EVERY_S, odometry.take).run()


def run() -> None:
    """Run `main` and end the process."""
    end_process(main())


if __name__ == '__main__':
    run()
