"""Process with ROS nodes: start, spin, and a clean end on any signal."""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import gc
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from types import FrameType
from typing import Any, NoReturn, cast

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from setcmas_simu.errors import SetcmasError
from setcmas_simu.option_groups import take_values
from setcmas_simu.reports import Launcher, Mistake, connected_launcher
from setcmas_simu.ros.dds_setup import dds_setup
from setcmas_simu.ros.fleet_node import destroy_nodes, note_arguments
from setcmas_simu.ros.polling import RequestWait

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_LONGEST_WAIT_S = 0.25
_LEAVES_S = 3
_PREFERRED = -10

# Each message class imports rosidl_generator_py, which tries to import the generator of such
# classes, with an IDL parser and a template engine. Here this import fails, which is harmless:
# a process of nodes then takes 3.4 MB less memory and starts sooner (benchmarks/fleet.py).
sys.modules.setdefault('rosidl_generator_py.generate_py_impl', cast(Any, None))


class RosProcess:
    """Spins the nodes of this process until a signal or `stop`.

    rclpy's own signal handlers invalidate the context at once, after which publishing fails.
    Here the handlers only set a flag, so that robots get zero velocity first.
    """

    def __init__(self, launcher: Launcher) -> None:
        """Prepare; `ros_process` initialises rclpy before."""
        self.launcher = launcher
        self.requests: RequestWait | None = None
        """Serves the nodes in place of the executor, if set."""
        self.stopping = False
        self.longest_end_s = 10
        """Seconds for the clean-up; after that the kernel kills the process."""
        self.status = 1
        """Exit status, if this process cannot leave ROS and must be ended."""
        self.on_stop_signal: Callable[[], None] | None = None
        """Called in the signal handler, for what cannot wait for the current callback."""

    @cached_property
    def executor(self) -> SingleThreadedExecutor:
        """The executor, which serves the nodes that are added to it."""
        return SingleThreadedExecutor()

    def add(self, *nodes: Node) -> None:
        """Add nodes to the executor."""
        for node in nodes:
            self.executor.add_node(node)

    def stop(self) -> None:
        """Make `spin` return after the current callback."""
        self.stopping = True

    @property
    def can_talk(self) -> bool:
        """Whether messages can be sent: a script may have shut down ROS in this process."""
        return bool(rclpy.ok())

    def serve(self, timeout_s: float) -> None:
        """Serve one callback if one is due within a time, possibly 0; stop if ROS shuts down."""
        timeout_s = min(max(0.0, timeout_s), _LONGEST_WAIT_S)  # a signal does not interrupt it
        if not self.can_talk:
            self.stop()
        elif self.requests:
            self.requests.wait(timeout_s)
        else:
            with contextlib.suppress(ExternalShutdownException):
                self.executor.spin_once(timeout_sec=timeout_s)

    def spin(self) -> None:
        """Serve callbacks until a stop is requested."""
        while not self.stopping:
            self.serve(_LONGEST_WAIT_S)

    def spin_until(
        self, condition: Callable[[], bool], timeout_s: float, every_s: float = 0.02
    ) -> bool:
        """Serve until a condition, checked every `every_s`, holds; False after a time-out."""
        deadline = time.monotonic() + timeout_s
        while not self.stopping and not condition() and time.monotonic() < deadline:
            self.serve(every_s)
        return condition()

    def take_signals(self) -> None:
        """Handle stop signals here; undo handlers and alarms of scripts."""
        for signum in STOP_SIGNALS:
            signal.signal(signum, self.handle_signal)
        # After a stop request, the alarm is the deadline of the clean-up.
        if not self.stopping and signal.getsignal(signal.SIGALRM) == signal.SIG_DFL:
            signal.signal(signal.SIGALRM, signal.SIG_IGN)

    def handle_signal(self, _signum: int, _frame: FrameType | None) -> None:
        """Set the stop flag, and the deadline for the clean-up."""
        self.stopping = True
        self.end_within(self.longest_end_s)
        if self.on_stop_signal:
            self.on_stop_signal()

    def end_within(self, seconds: int) -> None:
        """Have the kernel kill this process after this time, in case DDS never returns."""
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(seconds)


@contextlib.contextmanager
def ros_process(
    ros_arguments: Sequence[str] = (), launcher: Launcher | None = None
) -> Iterator[RosProcess]:
    """Initialise rclpy, yield the process, and shut everything down at the end.

    `ros_arguments` are those from `--ros-args` on; by default the launcher is the one that
    started this process. Raises SetcmasError if rclpy rejects the arguments.
    """
    # No log files: they would fill students' home folders, and the screen has what matters.
    arguments = [*ros_arguments, '--ros-args', '--disable-external-lib-logs']
    note_arguments(ros_arguments)
    try:
        with dds_setup():
            rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # of several classes, some private to rclpy
        reason = str(error).partition('\n')[0]
        raise SetcmasError(f'invalid arguments after --ros-args: {reason}') from error
    process = RosProcess(launcher or connected_launcher())
    process.take_signals()
    os.register_at_fork(after_in_child=_leave_signals)
    try:
        yield process
    finally:
        for signum in STOP_SIGNALS:
            signal.signal(signum, signal.SIG_IGN)
        with _exit_after(_LEAVES_S, process.status):
            if not process.requests:
                process.executor.shutdown()
            destroy_nodes()
            rclpy.try_shutdown()


class _TimerEvent(ctypes.Structure):
    """The sigevent of timer_create(2), for a function that a thread calls."""

    _fields_ = (
        ('value', ctypes.c_void_p),
        ('signal', ctypes.c_int),
        ('notify', ctypes.c_int),
        ('function', ctypes.c_void_p),
        ('rest', ctypes.c_void_p * 8),
    )


_CALL_IN_THREAD = 2  # SIGEV_THREAD


@contextlib.contextmanager
def _exit_after(seconds: int, status: int) -> Iterator[None]:
    """End this process with a status if the code inside takes longer.

    Fast DDS 2.14 never returns from deleting a participant that is just hearing of another
    process: DomainParticipantImpl::set_listener waits, with its mutex locked, for a callback that
    needs this mutex. Python's lock is held meanwhile, so only a thread of C can act.
    """
    if sys.platform != 'linux':
        yield
        return
    libc = ctypes.CDLL(None)
    timer = ctypes.c_void_p()
    function = ctypes.cast(libc._exit, ctypes.c_void_p)
    event = _TimerEvent(value=status, notify=_CALL_IN_THREAD, function=function)
    libc.timer_create(time.CLOCK_MONOTONIC, ctypes.byref(event), ctypes.byref(timer))
    interval_then_time = (ctypes.c_long * 4)(0, 0, seconds, 0)
    libc.timer_settime(timer, 0, interval_then_time, None)
    try:
        yield
    finally:
        libc.timer_delete(timer)


def node_main(
    parser: argparse.ArgumentParser,
    serve: Callable[[RosProcess, argparse.Namespace], int | None],
    argv: Sequence[str] | None = None,
) -> int:
    """Run a process of nodes and return its exit status.

    ROS gets the arguments from `--ros-args` on. `serve` works until the process must stop; it
    returns the exit status (None is 0), and a SetcmasError is printed and gives status 2.
    """
    take_values(parser)
    arguments = list(sys.argv[1:] if argv is None else argv)
    cut = arguments.index('--ros-args') if '--ros-args' in arguments else len(arguments)
    args, ros_arguments = parser.parse_args(arguments[:cut]), arguments[cut:]
    launcher = connected_launcher()
    gc.freeze()  # modules stay: collections need not visit them
    try:
        with ros_process(ros_arguments, launcher) as process:
            try:
                process.status = serve(process, args) or 0
            except SetcmasError as error:
                process.status = _reported(error, launcher)
            return process.status
    except SetcmasError as error:
        return _reported(error, launcher)


def _reported(error: SetcmasError, launcher: Launcher) -> int:
    launcher.report(Mistake(str(error)))
    print(f'{launcher.mistake}: {error}', file=sys.stderr, flush=True)
    return 2


def prefer_this_process() -> None:
    """Let this process and its later threads run before others, where the system allows it."""
    if hasattr(os, 'setpriority'):
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, 0, _PREFERRED)


def end_process(status: int) -> NoReturn:
    """End this process with an exit status at once, despite running threads of scripts.

    Call it after `ros_process`: DDS needs 0.2 s more to close what the kernel closes at once.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


def _leave_signals() -> None:
    """Restore the default stop signals in processes that a script forks."""
    for signum in STOP_SIGNALS:
        signal.signal(signum, signal.SIG_DFL)
