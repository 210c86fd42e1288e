"""Measures a simulated fleet under consensus, on this machine; prints figures, asserts nothing.

Run in the environment that setcmas is installed in, on a quiet machine:

    python tests/benchmarks/fleet.py [--nb-robots 8] [--duration 60] [--repeat 3]
"""

from __future__ import annotations

import argparse
import os
import platform
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path

os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 100)

import numpy as np
import psutil
import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from setcmas_simu.ros.dds_setup import dds_setup

SETCMAS = Path(sys.executable).parent / 'setcmas'


class Observer(Node):
    """Notes when messages of each robot arrive, as a separate participant."""

    def __init__(self, nb_robots: int) -> None:
        super().__init__('observer')
        self.arrivals: dict[str, list[list[float]]] = defaultdict(list)
        for kind, topic in ((Odometry, 'odom'), (TwistStamped, 'cmd_vel')):
            for robot in range(1, nb_robots + 1):
                times: list[float] = []
                self.arrivals[topic].append(times)
                self.create_subscription(
                    kind, f'/tb3_{robot}/{topic}', lambda _, t=times: t.append(time.time()), 50
                )

    def all_seen(self, topic: str) -> bool:
        return all(self.arrivals[topic])


def spin(executor: SingleThreadedExecutor, done, timeout: float) -> None:
    end = time.monotonic() + timeout
    while not done() and time.monotonic() < end:
        executor.spin_once(timeout_sec=0.05)


def tree(process: subprocess.Popen) -> list[psutil.Process]:
    root = psutil.Process(process.pid)
    return [root, *root.children(recursive=True)]


def cpu_s(processes: list[psutil.Process]) -> float:
    return sum(sum(p.cpu_times()[:2]) for p in processes)


def start(setcmas: Path, *arguments: str) -> tuple[float, subprocess.Popen]:
    begin = time.time()
    quiet = {'stdout': subprocess.DEVNULL, 'stderr': subprocess.DEVNULL}
    return begin, subprocess.Popen([setcmas, *arguments], **quiet)


def measure_fleet(nb_robots: int, duration: float, setcmas: Path = SETCMAS) -> dict[str, float]:
    """Start simu and ctrl, watch them for a while, and return figures by name."""
    with dds_setup():
        rclpy.init()
    observer = Observer(nb_robots)
    executor = SingleThreadedExecutor()
    executor.add_node(observer)
    simu_begin, simu = start(setcmas, 'simu', '--nb-robots', str(nb_robots))
    spin(executor, lambda: observer.all_seen('odom'), 30)
    spin(executor, lambda: False, 2)
    ctrl_begin, ctrl = start(setcmas, 'ctrl', '--algo', 'consensus')
    spin(executor, lambda: observer.all_seen('cmd_vel'), 30)
    spin(executor, lambda: False, 2)

    processes = {'simu': tree(simu), 'ctrl': tree(ctrl)}
    before = {name: cpu_s(group) for name, group in processes.items()}
    begin, wall = time.time(), time.monotonic()
    spin(executor, lambda: False, duration)
    wall = time.monotonic() - wall
    figures = {
        f'{name} cpu (core)': (cpu_s(group) - before[name]) / wall
        for name, group in processes.items()
    }
    figures['both cpu (core)'] = sum(figures.values())
    everything = [p for group in processes.values() for p in group]
    figures['both PSS (MB)'] = sum(p.memory_full_info().pss for p in everything) / 1e6
    figures['processes'] = len(everything)
    first = {topic: max(times[0] for times in lists) for topic, lists in observer.arrivals.items()}
    figures['simu to last odometry (s)'] = first['odom'] - simu_begin
    figures['ctrl to last cmd_vel (s)'] = first['cmd_vel'] - ctrl_begin
    gaps = [np.diff([t for t in times if t >= begin]) * 1e3 for times in observer.arrivals['odom']]
    figures['odometry median gap (ms)'] = float(np.median(np.concatenate(gaps)))
    figures['odometry largest gap (ms)'] = float(max(gap.max() for gap in gaps))
    expected = nb_robots * (wall * 10)
    figures['odometry messages of expected (%)'] = (
        100 * sum(len(gap) + 1 for gap in gaps) / expected
    )
    for process in (ctrl, simu):
        process.send_signal(signal.SIGINT)
        process.wait()
    rclpy.shutdown()
    return figures


def time_of_help(setcmas: Path = SETCMAS) -> float:
    """Return how long `setcmas --help` takes, in s."""
    begin = time.perf_counter()
    subprocess.run([setcmas, '--help'], stdout=subprocess.DEVNULL, check=True)
    return time.perf_counter() - begin


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--nb-robots', type=int, default=8)
    parser.add_argument('--duration', type=float, default=60.0)
    parser.add_argument('--repeat', type=int, default=3)
    args = parser.parse_args()
    print(f'{platform.platform()}, {os.cpu_count()} cores, Python {platform.python_version()}')
    helps = [time_of_help() for _ in range(7)]
    print(f'setcmas --help: {statistics.median(helps):.3f} s (median of 7)')
    runs = [measure_fleet(args.nb_robots, args.duration) for _ in range(args.repeat)]
    print(f'{args.nb_robots} robots, {args.duration:g} s, {args.repeat} runs: median (all)')
    for name in runs[0]:
        values = [run[name] for run in runs]
        each = ' '.join(f'{value:.3f}' for value in values)
        print(f'  {name:36} {statistics.median(values):8.3f}   ({each})')


if __name__ == '__main__':
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        main()
