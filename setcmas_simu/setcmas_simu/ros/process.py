"""Process that holds nodes: its start, its spinning, and an orderly end on any signal."""

from __future__ import annotations

import argparse
import contextlib
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from types import FrameType
from typing import Any, cast

import rclpy
from rcl_interfaces.msg import ParameterEvent
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription

from setcmas_simu.errors import SetcmasError
from setcmas_simu.reports.launcher import Launcher, connected_launcher
from setcmas_simu.reports.reports import Mistake
from setcmas_simu.ros.dds_setup import dds_setup

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_LONGEST_WAIT_S = 0.25
_AT_TIMES_S = 0.02


class FleetNode(Node):
    """A node of a fleet: without the services that cost a process with many nodes its start."""

    @classmethod
    def of_process(cls, node_name: str) -> FleetNode:
        """Return the node that speaks for its process: with parameter services, and /rosout."""
        return cls(node_name, enable_rosout=True, start_parameter_services=True)

    def __init__(self, node_name: str, **kwargs: Any) -> None:
        """Create the node; arguments as for `rclpy.node.Node`."""
        overrides = [
            Parameter('start_type_description_service', Parameter.Type.BOOL, False),
            *kwargs.pop('parameter_overrides', []),
        ]
        options = {'enable_rosout': False, 'start_parameter_services': False} | kwargs
        self._tells_parameters = options['start_parameter_services']
        super().__init__(node_name, parameter_overrides=overrides, **options)

    def create_publisher(self, msg_type: Any, *args: Any, **kwargs: Any) -> Publisher:
        """Create a publisher without the event callbacks that the executor would wait for."""
        if msg_type is ParameterEvent and not self._tells_parameters:
            return cast(Publisher, _NoParameterEvents())
        kwargs.setdefault('event_callbacks', PublisherEventCallbacks(use_default_callbacks=False))
        return super().create_publisher(msg_type, *args, **kwargs)

    def create_subscription(self, *args: Any, **kwargs: Any) -> Subscription:
        """Create a subscription without the event callbacks that the executor would wait for."""
        silent = SubscriptionEventCallbacks(use_default_callbacks=False)
        kwargs.setdefault('event_callbacks', silent)
        return super().create_subscription(*args, **kwargs)


class _NoParameterEvents:
    """Takes the events of parameters that nobody can set: an endpoint less for each node."""

    def publish(self, event: ParameterEvent) -> None:
        pass


class RosProcess:
    """Spins the nodes of this process until a signal or `stop` asks it to end.

    rclpy's own signal handlers invalidate the context at once, so nothing could be published any
    more; here the handlers only note the wish, and robots get their zero velocity first.

    Attributes:
        launcher: Is told what happens.
    """

    def __init__(self, launcher: Launcher) -> None:
        """Create an executor; `ros_process` has initialised rclpy."""
        self.launcher = launcher
        self.executor = SingleThreadedExecutor()
        self.stopping = False
        self.longest_end_s = 10
        """After that the kernel ends a process that hangs in its clean-up."""
        self.has_deadline = False
        self._served = 0.0
        self.on_stop_signal: Callable[[], None] | None = None
        """Called in the signal handler, for what cannot wait until the callback returns."""

    def add(self, *nodes: Node) -> None:
        """Let the executor serve nodes."""
        for node in nodes:
            self.executor.add_node(node)

    def stop(self) -> None:
        """Let `spin` return after the callback that runs now."""
        self.stopping = True

    @property
    def can_talk(self) -> bool:
        """Whether messages can be sent: a script may have shut ROS down in this process."""
        return bool(rclpy.ok())

    def serve(self, timeout_s: float) -> None:
        """Serve a callback if one is due within a time, which may be over; end with ROS."""
        try:
            # A signal does not wake a wait: its longest bounds the time to notice one.
            self.executor.spin_once(timeout_sec=min(max(0.0, timeout_s), _LONGEST_WAIT_S))
        except ExternalShutdownException:
            self.stop()

    def serve_at_times(self) -> None:
        """Serve a callback that is due, but look at most every 0.02 s: it takes long."""
        now = time.monotonic()
        if now - self._served >= _AT_TIMES_S:
            self._served = now
            self.serve(0.0)

    def spin(self) -> None:
        """Serve callbacks until something asks to stop."""
        while not self.stopping:
            self.serve(_LONGEST_WAIT_S)

    def spin_until(
        self, condition: Callable[[], bool], timeout_s: float, every_s: float = 0.02
    ) -> bool:
        """Serve callbacks until a condition holds; False if it did not within the timeout.

        Args:
            condition: Is looked at again and again.
            timeout_s: Longest time in s.
            every_s: Time in s from look to look, if nothing happens meanwhile.
        """
        deadline = time.monotonic() + timeout_s
        while not self.stopping and not condition() and time.monotonic() < deadline:
            self.serve(every_s)
        return condition()

    def take_signals(self) -> None:
        """Let the signals that ask to stop do so, and none that a script has ordered for later."""
        for signum in STOP_SIGNALS:
            signal.signal(signum, self.handle_signal)
        # Once it stops, the alarm is that of its own end.
        if not self.stopping and signal.getsignal(signal.SIGALRM) == signal.SIG_DFL:
            signal.signal(signal.SIGALRM, signal.SIG_IGN)

    def handle_signal(self, _signum: int, _frame: FrameType | None) -> None:
        """Note the wish to stop, and set the deadline for the clean-up."""
        self.stopping = True
        self.end_within(self.longest_end_s)
        if self.on_stop_signal:
            self.on_stop_signal()

    def end_within(self, seconds: int) -> None:
        """Let this process be killed by then: what DDS waits for may never come."""
        self.has_deadline = True
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(seconds)


@contextlib.contextmanager
def ros_process(
    ros_arguments: Sequence[str] = (), launcher: Launcher | None = None
) -> Iterator[RosProcess]:
    """Initialise rclpy, hand out the process, and shut everything down at the end.

    Args:
        ros_arguments: What follows and includes `--ros-args`.
        launcher: Is told what happens; by default the one that started this process.

    Raises:
        SetcmasError: rclpy does not understand the arguments.
    """
    # No log files: students' home folders would fill, and what matters is on the screen.
    arguments = [*ros_arguments, '--ros-args', '--disable-external-lib-logs']
    try:
        with dds_setup():
            rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # of several classes, some of them private to rclpy
        reason = str(error).partition('\n')[0]
        raise SetcmasError(f'what follows --ros-args is not understood: {reason}') from error
    process = RosProcess(launcher or connected_launcher())
    process.take_signals()
    os.register_at_fork(after_in_child=_leave_signals)
    try:
        yield process
    finally:
        for signum in STOP_SIGNALS:
            signal.signal(signum, signal.SIG_IGN)
        had_deadline = process.has_deadline
        if not had_deadline:
            process.end_within(process.longest_end_s)
        process.executor.shutdown()
        rclpy.try_shutdown()
        if not had_deadline:
            signal.alarm(0)


def node_main(
    parser: argparse.ArgumentParser,
    serve: Callable[[RosProcess, argparse.Namespace], int | None],
    argv: Sequence[str] | None = None,
) -> int:
    """Run a process of nodes; returns its exit status.

    Args:
        parser: Takes the process's own options; what follows `--ros-args` is for ROS.
        serve: Works until the process is asked to stop; returns the exit status, None is 0. A
            SetcmasError that it raises is told: status 2.
        argv: The command line; this process's by default.
    """
    own_arguments, ros_arguments = split_ros_arguments(sys.argv[1:] if argv is None else argv)
    args = parser.parse_args(own_arguments)
    launcher = connected_launcher()
    try:
        with ros_process(ros_arguments, launcher) as process:
            return serve(process, args) or 0
    except SetcmasError as error:
        launcher.tell(Mistake(str(error)))
        print(f'{launcher.mistake}: {error}', file=sys.stderr, flush=True)
        return 2


def _leave_signals() -> None:
    """Let the signals that ask to stop end a process that a script has forked, without a word."""
    for signum in STOP_SIGNALS:
        signal.signal(signum, signal.SIG_DFL)


def split_ros_arguments(argv: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the arguments before `--ros-args`, and from it on."""
    arguments = list(argv)
    cut = arguments.index('--ros-args') if '--ros-args' in arguments else len(arguments)
    return arguments[:cut], arguments[cut:]
