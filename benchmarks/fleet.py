"""Measures simulated fleets under consensus, on this machine; prints figures, asserts nothing.

Figures are of the processes of the nodes alone, simulator and controllers: their launchers, the
commands `setcmas simu` and `setcmas ctrl`, only wait.

Run in the environment that setcmas is installed in, on a quiet machine:

    python benchmarks/fleet.py --nb-robots 8 20 50 100 250 [--duration 30] [--repeat 1]

prints a table and draws the cost against the number of robots into fleet.png. To compare with
another version, give both commands: --setcmas .venv/bin/setcmas /elsewhere/bin/setcmas; they take
turns.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 100)
os.environ.pop('PYTHONDONTWRITEBYTECODE', None)  # else each start would compile all modules

import matplotlib

matplotlib.use('Agg')

import matplotlib.pyplot as plt
import numpy as np
import psutil
import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from quick_option import parsed
from rclpy.qos import QoSProfile
from tabulate import tabulate

from setcmas_simu.ros.dds_setup import dds_setup
from setcmas_simu.ros.fleet_node import FleetNode

SETCMAS = Path(sys.executable).parent / 'setcmas'
ROBOT_HZ, CONTROL_HZ = 10.0, 5.0
LOOK_S = 0.5
NODE_MODULE = re.compile(r'setcmas_(simu|ctrl)\.')
DEPTH = 50  # messages that wait for a look, more than come in between


@dataclass
class Observer:
    """Notes when messages of each robot arrive, as a participant of its own that looks seldom."""

    nb_robots: int
    times: dict[str, list[list[float]]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.node = FleetNode('observer')
        self.subscriptions = {}
        for kind, topic in ((Odometry, 'odom'), (TwistStamped, 'cmd_vel')):
            robots = range(1, self.nb_robots + 1)
            self.times[topic] = [[] for _ in robots]
            self.subscriptions[topic] = [
                self.node.create_subscription(
                    kind, f'/tb3_{robot}/{topic}', print, QoSProfile(depth=DEPTH)
                )
                for robot in robots
            ]

    def look(self) -> None:
        """Take what has come, undecoded; DDS has noted when it came."""
        for topic, subscriptions in self.subscriptions.items():
            for subscription, times in zip(subscriptions, self.times[topic], strict=True):
                with subscription.handle:
                    while taken := subscription.handle.take_message(subscription.msg_type, True):
                        times.append(taken[1]['received_timestamp'] * 1e-9)

    def wait_for(self, topic: str, timeout: float) -> None:
        end = time.monotonic() + timeout
        while not all(self.times[topic]):
            if time.monotonic() > end:
                silent = sum(not times for times in self.times[topic])
                raise SystemExit(f'{silent} robots have no {topic} after {timeout:g} s')
            time.sleep(0.05)
            self.look()

    def watch(self, duration: float) -> None:
        end = time.monotonic() + duration
        while time.monotonic() < end:
            time.sleep(LOOK_S)
            self.look()


def node_process(launcher: subprocess.Popen) -> psutil.Process:
    """Return the process below a launcher that runs a module of nodes, in any version."""
    below = psutil.Process(launcher.pid).children(recursive=True)
    nodes = [one for one in below if any(map(NODE_MODULE.match, one.cmdline()))]
    if not nodes:
        raise SystemExit(f'{launcher.args} has not started a process of nodes')
    return nodes[-1]  # a supervisor in between may have the same words


def cpu_s(process: psutil.Process) -> float:
    return sum(process.cpu_times()[:2])


def pss_mb(process: psutil.Process) -> float:
    return process.memory_full_info().pss / 1e6


def start(setcmas: Path, *arguments: str) -> tuple[float, subprocess.Popen]:
    begin = time.time()
    quiet = {'stdout': subprocess.DEVNULL, 'stderr': subprocess.DEVNULL}
    return begin, subprocess.Popen([setcmas, *arguments], **quiet)


def measure_fleet(nb_robots: int, duration: float, setcmas: Path = SETCMAS) -> dict[str, float]:
    """Start simu and ctrl, watch them for a while, and return figures by name."""
    with dds_setup():
        rclpy.init()
    observer = Observer(nb_robots)
    simu_begin, simu = start(setcmas, 'simu', '--nb-robots', str(nb_robots))
    ctrl = None
    try:
        observer.wait_for('odom', 60)
        ctrl_begin, ctrl = start(setcmas, 'ctrl', '--algo', 'consensus')
        observer.wait_for('cmd_vel', 60)
        processes = {'simu': node_process(simu), 'ctrl': node_process(ctrl)}
        start_cpu = sum(map(cpu_s, processes.values()))
        observer.watch(6.0)  # until the services for parameters have started, too
        before = {name: cpu_s(one) for name, one in processes.items()}
        begin, wall = time.time(), time.monotonic()
        observer.watch(duration)
        wall, end = time.monotonic() - wall, time.time()
        cores = {name: (cpu_s(one) - before[name]) / wall for name, one in processes.items()}
        memory = {name: pss_mb(one) for name, one in processes.items()}
    finally:
        for process in (ctrl, simu):
            if process:
                process.send_signal(signal.SIGINT)
                process.wait()
    observer.look()
    first = {topic: max(times[0] for times in lists) for topic, lists in observer.times.items()}
    figures = {
        'simu (core)': cores['simu'],
        'ctrl (core)': cores['ctrl'],
        'both (core)': sum(cores.values()),
        'simu PSS (MB)': memory['simu'],
        'ctrl PSS (MB)': memory['ctrl'],
        'both PSS (MB)': sum(memory.values()),
        'CPU until cmd_vel (s)': start_cpu,
        'simu ready (s)': first['odom'] - simu_begin,
        'ctrl ready (s)': first['cmd_vel'] - ctrl_begin,
    }
    for topic, rate in (('odom', ROBOT_HZ), ('cmd_vel', CONTROL_HZ)):
        seen = [np.array([t for t in one if begin <= t < end]) for one in observer.times[topic]]
        figures[f'{topic} gap (ms)'] = max(np.diff(one).max() for one in seen) * 1e3
        missing = [max(0, int(rate * (end - begin)) - 1 - len(one)) for one in seen]
        figures[f'{topic} missing'] = sum(missing)
    rclpy.shutdown()
    return figures


def draw(sizes: list[int], medians: dict[int, dict[str, float]], path: Path) -> None:
    """Draw cores and memory against the number of robots."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout='constrained')
    labels = {'simu': 'simulator', 'ctrl': 'controllers', 'both': 'both'}
    for axes, unit, title in ((left, '(core)', 'cores'), (right, 'PSS (MB)', 'memory (PSS, MB)')):
        for (name, label), style in zip(labels.items(), ('o-', 's-', 'D-'), strict=True):
            values = [medians[size][f'{name} {unit}'] for size in sizes]
            axes.plot(sizes, values, style, label=label, markersize=4)
        axes.set(xlabel='robots', ylabel=title, xlim=(0, None), ylim=(0, None))
        axes.grid(alpha=0.3)
    left.legend(frameon=False)
    figure.savefig(path, dpi=120)


def time_of_help(setcmas: Path = SETCMAS) -> float:
    """Return how long `setcmas --help` takes, in s."""
    begin = time.perf_counter()
    subprocess.run([setcmas, '--help'], stdout=subprocess.DEVNULL, check=True)
    return time.perf_counter() - begin


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--nb-robots', type=int, nargs='+', default=[8, 20, 50, 100, 250])
    parser.add_argument('--duration', type=float, default=30.0)
    parser.add_argument('--repeat', type=int, default=1)
    parser.add_argument('--setcmas', type=Path, nargs='+', default=[SETCMAS])
    parser.add_argument('--picture', type=Path, default=Path('fleet.png'))
    args = parsed(parser, nb_robots=[2], duration=3.0, repeat=1)
    picture = args.picture.resolve()
    print(f'{platform.platform()}, {os.cpu_count()} cores, Python {platform.python_version()}')
    helps = [time_of_help() for _ in range(7)]
    print(f'setcmas --help: {statistics.median(helps):.3f} s (median of 7)')
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for setcmas, medians in measure(args).items():
            if len(args.setcmas) > 1:
                print(setcmas)
            rows = [
                [name, *(f'{medians[size][name]:.4g}' for size in args.nb_robots)]
                for name in medians[args.nb_robots[0]]
            ]
            print(f'medians of {args.repeat}, {args.duration:g} s each')
            print(tabulate(rows, ['robots', *args.nb_robots], disable_numparse=True), flush=True)
            draw(args.nb_robots, medians, picture)
    print(picture)


def measure(args: argparse.Namespace) -> dict[Path, dict[int, dict[str, float]]]:
    """Return the median figures of each version and number of robots; the versions take turns."""
    runs: dict[tuple[Path, int], list[dict[str, float]]] = {}
    for setcmas in args.setcmas:
        measure_fleet(2, 0.5, setcmas)  # compiles the modules, as the first start does
    for _ in range(args.repeat):
        for nb_robots in args.nb_robots:
            for setcmas in args.setcmas:
                figures = measure_fleet(nb_robots, args.duration, setcmas)
                runs.setdefault((setcmas, nb_robots), []).append(figures)
                print(f'  {nb_robots}: {figures["both (core)"]:.3f} core', flush=True)
    medians: dict[Path, dict[int, dict[str, float]]] = {}
    for (setcmas, nb_robots), figures in runs.items():
        medians.setdefault(setcmas, {})[nb_robots] = {
            name: statistics.median(one[name] for one in figures) for name in figures[0]
        }
    return medians


if __name__ == '__main__':
    main()
