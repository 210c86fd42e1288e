"""An experiment in an emulated lab, its faults, and what the wheels of its robots really do."""

import itertools
import math
import os
import pty
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import psutil
from nav_msgs.msg import Odometry
from processes import SETCMAS, TIMEOUT_S, die_with_parent
from ros_peer import Peer
from std_msgs.msg import String
from terminals import pressed_until

from setcmas_simu.fleet.planar_pose import wrap_angle, yaw_of_quaternion
from setcmas_simu.fleet.topics import truth_topic

LAW = Path(__file__).parent / 'setcmas_expe' / 'scripts' / 'rehearsal_law.py'
POSES = ('--pose', '1:2.4,0,1.57', '--pose', '2:-0.6,0,1.57')
CTRL = 'setcmas_ctrl.controllers.controller_processes'
BRIDGES = 'setcmas_expe.bridges'
PAUSE = 'setcmas_expe.pause.pause_node'
STANDS_S = 0.4  # zero for this long is a stop


@dataclass(frozen=True)
class Truth:
    """What an emulated robot really does at a moment (s since 1970, m, rad, m/s, rad/s)."""

    stamp: float
    x: float
    y: float
    theta: float
    V: float
    omega: float

    @classmethod
    def of(cls, message):
        p, q = message.pose.pose.position, message.pose.pose.orientation
        twist = message.twist.twist
        stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        theta = yaw_of_quaternion(q.x, q.y, q.z, q.w)
        return cls(stamp, p.x, p.y, theta, twist.linear.x, twist.angular.z)

    @property
    def rolls(self) -> float:
        """Speed of the wheels that must become zero."""
        return max(abs(self.V), 0.08 * abs(self.omega))

    def way_from(self, before: 'Truth') -> float:
        """How far the wheels can have rolled since; nowhere while the emulated lab stalled."""
        turn = abs(wrap_angle(self.theta - before.theta))
        return math.dist((self.x, self.y), (before.x, before.y)) + 0.08 * turn

    def rolls_towards(self, angle: float) -> float:
        """Speed of the wheels in a direction of the world that is forbidden."""
        return max(0.0, self.V * math.cos(angle - self.theta))


@dataclass(frozen=True)
class Stop:
    """How a robot came to a stop."""

    seconds: float
    metres: float


def stop_of(samples, fault, rolls=lambda truth: truth.rolls):
    """Return the stop after a fault (s since 1970); None if there is none in the samples."""
    metres, since, at = 0.0, None, None
    for before, truth in itertools.pairwise(samples):
        if truth.stamp < fault:
            continue
        if rolls(truth) > 1e-6:
            seconds = truth.stamp - max(fault, before.stamp)
            metres += min(rolls(truth) * seconds, truth.way_from(before))
            since = None
        elif since is None:
            since, at = truth.stamp, metres
        if since is not None and truth.stamp - since >= STANDS_S:
            return Stop(since - fault, at)
    return None


def watch(peer: Peer, robot: int) -> list[Truth]:
    """Return the list that the truth about a robot is appended to from now on."""
    samples: list[Truth] = []
    peer.node.create_subscription(
        Odometry,
        truth_topic(robot),
        lambda message: samples.append(Truth.of(message)),
        100,
    )
    return samples


class Rehearsal:
    """`setcmas expe --emulate`, seen and disturbed by a peer."""

    def __init__(
        self,
        peer: Peer,
        folder: Path,
        *options: str,
        nb_robots: int = 2,
        before: Sequence[str] = (),
        lab: Sequence[str] = ('--emulate', *POSES),
        **environment: str,
    ) -> None:
        """Start it, with `before` in front of the command and with `lab` for where it is."""
        self.peer = peer
        self.mode = folder / 'mode.txt'
        self.mode.unlink(missing_ok=True)
        self.log = folder / 'expe.txt'
        self.truth = {robot: watch(peer, robot) for robot in range(1, nb_robots + 1)}
        self._fault = peer.node.create_publisher(String, '/emulated_lab/fault', 10)
        self.others: list = []
        """Publishers of somebody else's, while a fault lasts."""
        self.commands: list = []
        """Processes of somebody else's."""
        self.network = None
        """The network, where robots are on another machine."""
        self.terminal, terminal = pty.openpty()
        command = [*before, *SETCMAS, 'expe', '--algo', str(LAW), *lab]
        with self.log.open('wb') as log:
            self.process = subprocess.Popen(
                [*command, '--no-joystick', '--nb-robots', str(nb_robots), *options],
                env={**os.environ, 'SETCMAS_REHEARSAL': str(self.mode), **environment},
                stdin=terminal,
                stdout=log,
                stderr=log,
                start_new_session=True,
                preexec_fn=_take_terminal,
            )
        os.close(terminal)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        children = self._children()
        self.process.terminate()
        try:
            self.process.wait(TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        for child in psutil.wait_procs(children, TIMEOUT_S)[1]:
            child.kill()
        self.close_terminal()

    def output(self) -> str:
        return self.log.read_text(errors='replace')

    def let_go(self, speed: float = 0.15) -> None:
        """Start the robots, and wait until all go faster than a speed (m/s)."""
        self.peer.wait_for(lambda: all(self.truth.values()))
        self.peer.wait_for(lambda: 'controlling robot' in self.output())
        self.press_until(lambda: self._all_go(speed))

    def _all_go(self, speed: float) -> bool:
        return all(speed < samples[-1].V for samples in self.truth.values())

    def press(self, keys: str) -> float:
        """Press keys in its terminal; returns when, in s since 1970."""
        now = time.time()
        os.write(self.terminal, keys.encode())
        return now

    def press_until(self, condition: Callable[[], bool], key: str = 's') -> None:
        """Press a key, by default the one that starts robots, until a condition holds."""
        try:
            self.peer.wait_for(pressed_until(lambda: self.press(key), condition))
        except AssertionError as error:
            raise AssertionError(f'{error}\n{self.output()[-3000:]}') from None

    def fault(self, text: str) -> float:
        """Order a fault from the emulated lab; returns when, in s since 1970."""
        self.peer.wait_for(lambda: self._fault.get_subscription_count() > 0)
        self._fault.publish(String(data=text))
        return time.time()

    def kill(self, module: str, signum: int = signal.SIGKILL) -> float:
        """Signal the process that runs a module; returns when."""
        (child,) = [c for c in self._children() if module in c.cmdline()]
        child.send_signal(signum)
        return time.time()

    def signal(self, signum: int) -> float:
        """Signal the launcher; returns when."""
        now = time.time()
        self.process.send_signal(signum)
        return now

    def press_ctrl_c(self) -> float:
        """Type Ctrl-C; returns when."""
        return self.press('\x03')

    def close_terminal(self) -> float:
        """Close the terminal's window; returns when."""
        now = time.time()
        if self.terminal >= 0:
            os.close(self.terminal)
            self.terminal = -1
        return now

    def set_mode(self, mode: str) -> float:
        """Let the control law behave otherwise from now on; returns when."""
        partial = self.mode.with_suffix('.partial')
        partial.write_text(mode)
        partial.replace(self.mode)
        return time.time()

    def wait_for_stop(self, fault: float, robot: int = 1, rolls=lambda truth: truth.rolls) -> Stop:
        """Wait until a robot has stopped after a fault."""
        found = None

        def stopped():
            nonlocal found
            found = stop_of(self.truth[robot], fault, rolls)
            return found is not None

        self.peer.wait_for(stopped)
        return found

    def way(self, robot: int = 1) -> float:
        """Return how far (m) a robot has gone, as far as this peer has seen."""
        pairs = itertools.pairwise(self.truth[robot])
        return sum(after.way_from(before) for before, after in pairs)

    def _children(self):
        try:
            return psutil.Process(self.process.pid).children(recursive=True)
        except psutil.NoSuchProcess:
            return []


def _take_terminal():
    die_with_parent()
    import fcntl
    import termios

    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
