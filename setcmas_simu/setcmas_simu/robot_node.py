"""Basis of the nodes of a robot: a node in its namespace, which is stepped instead of spun.

    class Follower(RobotNode):
        def __init__(self):
            super().__init__('follower')
            self.odom = self.newest(Odometry, 'odom')
            self.cmd_vel = self.create_publisher(TwistStamped, 'cmd_vel', qos.COMMAND)

        def step(self):
            if message := self.odom():
                ...

A process may have such nodes of many robots. They poll their topics when they are stepped: a
callback for each message would cost twice the processor time.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import ROBOT_PATTERN, robot_name
from setcmas_simu.option_kinds import Number
from setcmas_simu.ros.clocks import SteadyClock
from setcmas_simu.ros.fleet_node import FleetNode, of_other_nodes
from setcmas_simu.ros.process import RosProcess

_POLL_EVERY_S = 0.01
_SAME_TIME = 1e-6
_FINITE = Number(least=-1e6, most=1e6)


class StepTime:
    """Time of the current step, the same for all nodes of a process.

    Attributes:
        period: Time between steps in s; a change takes effect at the next step.
        clock: Clock of the steps.
        now: Time of the current step, in s on the clock.
        stamp: The same for the headers of messages.
        t: Time of the run in s, as control laws see it: it stands still in a pause.
        is_polled: Whether the loop also polls between steps, for messages that cannot wait.
    """

    def __init__(self, period: float, clock: SteadyClock | None = None) -> None:
        self.period = period
        self.clock = clock or SteadyClock()
        self.t = 0.0
        self.is_polled = False
        self.begin_step(self.clock.now())

    def begin_step(self, now: float) -> None:
        """Let all nodes have this time from now on."""
        self.now, self.stamp = now, self.clock.stamp()


class RobotNode(FleetNode):
    """A node of one robot, alone in its process or with others.

    Attributes:
        robot: Number of the robot.
        time: Time of the current step.
    """

    def __init__(
        self,
        name: str,
        robot: int | None = None,
        fleet: FleetNode | None = None,
        time: StepTime | None = None,
        follows_clock: bool = True,
        **kwargs: Any,
    ) -> None:
        """Create the node in the namespace of its robot, such as /tb3_3.

        Args:
            name: Name of the node.
            robot: Number of the robot. A node that is alone in its process gets it from its
                namespace, or from the parameter robot_no.
            fleet: The node that stands for the fleet in this process; None if this one is alone.
                In a fleet, its services for parameters start late (`RequestWait`).
            time: Time of the steps, which all nodes of a process share.
            follows_clock: Whether it may have use_sim_time.
            **kwargs: As for `rclpy.node.Node`.

        Raises:
            SetcmasError: A parameter is invalid.
        """
        is_alone = fleet is None  # else --ros-args are for many nodes
        if fleet is not None and robot is not None:
            kwargs |= {'namespace': f'{fleet.fleet_namespace}/{robot_name(robot)}'}
            kwargs |= of_other_nodes()
        kwargs.setdefault('namespace', robot_name(1))  # unless ROS's own -r __ns:= says another
        kwargs.setdefault('start_parameter_services', is_alone)
        super().__init__(name, follows_clock, **kwargs)
        self.time = time or StepTime(0.1)
        named = ROBOT_PATTERN.search(f'{self.get_namespace()}/')
        number = robot or int(named[1] if named else 1)
        number = self.fixed('robot_no', number, 'number of the robot', is_alone)
        if not isinstance(number, int) or number < 1:
            raise SetcmasError(f'parameter robot_no is {number!r}; it must be a number from 1')
        if named and int(named[1]) != number:
            raise SetcmasError(
                f'robot_no is {number} in namespace {self.get_namespace()}; add -r __ns:='
                f'/{robot_name(number)} after --ros-args'
            )
        self.robot = number
        text = 'namespace of the topics that the whole fleet shares, such as /pause'
        namespace = self.fixed('fleet_namespace', self.fleet_namespace, text, is_alone)
        self.fleet_namespace = namespace.rstrip('/')
        self._warned: set[str] = set()

    @cached_property
    def fleet_namespace(self) -> str:
        """Namespace of the fleet: by default that of this node without the robot's name."""
        return re.sub(r'/tb3_\d+$', '', self.get_namespace().rstrip('/'))

    def number(self, name: str, value: float, text: str) -> float:
        """Do the same as `fixed` for a finite number; otherwise raise SetcmasError."""
        number = self.fixed(name, float(value), text)
        _FINITE.check(f'parameter {name}', number)
        return float(number)

    def warn(self, text: str) -> None:
        """Show a warning."""
        self.get_logger().warning(text)

    def warn_once(self, key: str, text: str) -> None:
        """Show a warning, unless one with this key was shown before."""
        if key not in self._warned:
            self._warned.add(key)
            self.warn(text)

    def step(self) -> None:
        """Work for one period."""

    def stop(self) -> None:
        """Publish the last words of this node, while it still can."""


_MOST_WITH_SERVICES = 20  # robots
_SERVICES_AFTER_S = 2.0  # of real time: other processes may start meanwhile
_FOR_SERVICES = 0.1  # part of a period


def with_services(nodes: Sequence[RobotNode]) -> Sequence[RobotNode]:
    """Return the nodes of a process that are to get services for parameters; none if many."""
    return nodes if len({node.robot for node in nodes}) <= _MOST_WITH_SERVICES else ()


def run_steps(
    process: RosProcess,
    time: StepTime,
    step: Callable[[], object],
    poll: Callable[[], object] = bool,
) -> None:
    """Step at once and then every period, until the process must stop.

    In between, the process serves rare callbacks. The step itself polls frequent messages: a
    callback for each would wake an executor that rebuilds its wait set every time. A late step
    does not shift the next ones; steps whose time has passed are skipped.

    Args:
        process: The process of the nodes.
        time: Time of the steps.
        step: Called at each step.
        poll: Called between steps, while the time says so.
    """
    clock = time.clock
    due = first = clock.now()
    while not process.stopping:
        time.begin_step(clock.now())
        step()
        if process.requests and due - first >= _SERVICES_AFTER_S * clock.rtf:
            process.requests.start_services(_FOR_SERVICES * time.period / clock.rtf)
        due += time.period
        behind = clock.now() - due
        if behind > 0.0:
            due += time.period * math.floor(behind / time.period)
        if time.is_polled:
            _poll_until(due, process, clock, poll)
        clock.wait_until(due, process)


def _poll_until(
    due: float, process: RosProcess, clock: SteadyClock, poll: Callable[[], object]
) -> None:
    """Poll every 0.01 s, counted back from the next step: the last poll just precedes it."""
    nb_polls = math.ceil((due - clock.now()) / _POLL_EVERY_S - _SAME_TIME) - 1
    for left in range(nb_polls, 0, -1):
        clock.wait_until(due - left * _POLL_EVERY_S, process)
        if process.stopping:
            return
        poll()
