"""Guard against two simulators of the same robots."""

from __future__ import annotations

import contextlib
import os
import stat
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros import cmd_vel_topics
from setcmas_simu.ros.process import FleetNode

_ENTRY_SIZE = 16  # bytes


class RobotLocks:
    """Holds the locks of some robots in a ROS domain and namespace until the process ends.

    A lock covers the robot's entry in one file per domain, which names its holder; any number of
    robots needs only one descriptor.
    """

    def __init__(self, robots: list[int], namespace: str = '') -> None:
        """Lock robots (sorted); raise SetcmasError if another process holds one."""
        domain = os.environ.get('ROS_DOMAIN_ID', '0')
        self._file = _lock_file(_path(domain, namespace))
        taken = {robot: holder for robot in robots if (holder := self._take(robot))}
        if taken:
            self.release()
            raise SetcmasError(
                f'{robots_in_words(list(taken), "are")} already simulated by process '
                f'{next(iter(taken.values()))} in ROS domain {domain}: stop the other simulator, '
                'or set another ROS_DOMAIN_ID'
            )

    def release(self) -> None:
        """Release the locks."""
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def _take(self, robot: int) -> str | None:
        """Lock a robot; return the holder if another process has the lock, else None."""
        if self._file is None:
            return None
        import fcntl  # POSIX only

        place = robot * _ENTRY_SIZE
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB, _ENTRY_SIZE, place)
        except OSError:
            holder = os.pread(self._file, _ENTRY_SIZE, place).decode(errors='replace').strip()
            return holder or 'of another user'
        os.pwrite(self._file, f'{os.getpid():<{_ENTRY_SIZE}}'.encode(), place)
        return None


def _lock_file(path: Path) -> int | None:
    """Open the file of the locks; without it the ROS graph must show other simulators."""
    if not hasattr(os, 'O_NOFOLLOW'):  # Windows has no such locks
        return None
    try:
        # Other users can put a link, a folder or a pipe into the shared folder.
        file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)
    except OSError:
        return None
    if stat.S_ISREG(os.fstat(file).st_mode):
        return file
    os.close(file)
    return None


def _path(domain: str, namespace: str = '') -> Path:
    # Hosts made of network namespaces share a disk, but not their robots.
    network = 0
    with contextlib.suppress(OSError):
        network = Path('/proc/self/ns/net').stat().st_ino
    name = f'setcmas_{network}_{domain}{namespace.replace("/", ".")}.locks'
    return Path(tempfile.gettempdir()) / name


_DISCOVERY_S = {'LOCALHOST': 0.4}
_NETWORK_DISCOVERY_S = 1.0
_LOOKS = 50  # robots checked per call
_FORGOTTEN_AFTER_S = 6.0  # one second more than the lease in config/fastdds_network.xml


class DuplicateSimulators:
    """Finds other simulators of these robots, by locks on this host and in the ROS graph."""

    def __init__(self, node: FleetNode, robots: list[int]) -> None:
        """Lock the robots on this host, or raise SetcmasError; start discovery elsewhere."""
        self._locks = RobotLocks(robots, node.fleet_namespace)
        self._node = node
        self._own = {cmd_vel_topics.own_participant(node)}
        self._robots = robots
        self._started = time.monotonic()
        self._turn = robots
        self._suspects: set[int] = set()
        self._warned: set[int] = set()

    def others(self, robot: int) -> list[str]:
        """Return the full names of nodes of other processes that publish a robot's odometry."""
        topic = topics.robot_topic(robot, topics.ODOM)
        return cmd_vel_topics.strangers(self._node, topic, self._own)

    def _seen(self, robots: Sequence[int]) -> dict[int, list[str]]:
        return {robot: names for robot in robots if (names := self.others(robot))}

    def refuse_second_simulator(self) -> None:
        """Wait for discovery; raise SetcmasError if another node publishes a robot's odometry."""
        discovery_range = os.environ.get('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
        wait = _DISCOVERY_S.get(discovery_range, _NETWORK_DISCOVERY_S)
        time.sleep(max(0.0, self._started + wait - time.monotonic()))
        seen = self._seen(self._robots)
        if seen:
            # A killed process stays on the graph for a while.
            self._node.get_logger().info('others publish odometry; waiting to see if they stay')
            deadline = time.monotonic() + _FORGOTTEN_AFTER_S
            while seen and time.monotonic() < deadline:
                time.sleep(0.1)
                seen = self._seen(self._robots)
        if seen:
            example = next(iter(seen.values()))[0]
            raise SetcmasError(
                f'{robots_in_words(list(seen), "are")} already simulated in ROS domain '
                f'{os.environ.get("ROS_DOMAIN_ID", "0")} (node {example} publishes odometry): '
                'stop the other simulator, or set another ROS_DOMAIN_ID'
            )

    def warn_of_latecomers(self) -> None:
        """Warn once per robot when another publisher of its odometry has appeared and stayed.

        Each call checks some robots, and the next call continues with the next ones.
        """
        some, self._turn = self._turn[:_LOOKS], self._turn[_LOOKS:] or self._robots
        seen = self._seen(some)
        # A second simulator is visible briefly before it refuses to start.
        staying = self._suspects & set(seen)
        self._suspects = (self._suspects - set(some)) | set(seen)
        for robot, names in seen.items():
            if robot in staying - self._warned:
                self._warned.add(robot)
                self._node.get_logger().warning(
                    f'{names[0]} also publishes the odometry of {topics.robot_name(robot)}: '
                    'two simulators move it; stop one of them'
                )
