"""Measures what the live page costs while a browser shows it; prints figures, asserts nothing.

Needs chromium and chromium-driver. Robots move under traj_tracking, the law that draws most. The
browser itself is not counted. Run in the environment that setcmas is installed in, on a quiet
machine:

    python benchmarks/view.py [--nb-robots 8 50 250] [--duration 30]
"""

from __future__ import annotations

import argparse
import os
import platform
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 100)
sys.path.insert(0, str(Path(__file__).parents[1] / 'tests'))

import psutil
from browser import open_browser, wait_for
from quick_option import parsed

SETCMAS = Path(sys.executable).parent / 'setcmas'
_COUNT = """
const done = arguments[arguments.length - 1];
const drawn = page.player.pictures, begin = performance.now();
setTimeout(() => done((page.player.pictures - drawn) / (performance.now() - begin) * 1e3), 5000);
"""
_DRAWN = 'return performance.now() * (page.robots.some(robot => robot.pose) ? 1 : NaN)'


def start(log: Path, setcmas: Path, *arguments: str) -> subprocess.Popen:
    with log.open('wb') as file:
        return subprocess.Popen([setcmas, *arguments], stdout=file, stderr=file)


def node_of(process: subprocess.Popen) -> psutil.Process:
    return psutil.Process(process.pid).children()[0]


def cpu_s(process: psutil.Process) -> float:
    return sum(process.cpu_times()[:2])


def url_in(log: Path) -> str:
    while 'http://' not in log.read_text():
        time.sleep(0.1)
    return log.read_text().split()[2]


def load(view: psutil.Process, duration: float) -> float:
    """Return the share of a core that a process takes over some seconds."""
    before, begin = cpu_s(view), time.monotonic()
    time.sleep(duration)
    return (cpu_s(view) - before) / (time.monotonic() - begin)


def measure_view(
    nb_robots: int, algo: str, duration: float, folder: Path, setcmas: Path = SETCMAS
) -> dict[str, float]:
    """Let a browser show a fleet for a while, and return figures by name."""
    simu = start(folder / 'simu', setcmas, 'simu', '--nb-robots', str(nb_robots))
    ctrl = start(folder / 'ctrl', setcmas, 'ctrl', '--algo', algo)
    view = start(folder / 'view', setcmas, 'view')
    try:
        url = url_in(folder / 'view')
        time.sleep(5 + nb_robots / 25)
        idle = load(node_of(view), 5)
        with open_browser(1280, 800, every_picture=True) as browser:
            browser.get(url)
            wait_for(lambda: browser.execute_script(_DRAWN) is not None)
            first = browser.execute_script(_DRAWN)
            wait_for(lambda: browser.execute_script('return page.robots.length') == nb_robots)
            time.sleep(5)
            busy = load(node_of(view), duration)
            pictures = browser.execute_async_script(_COUNT)
        return {
            'page open (core)': busy,
            'no page open (core)': idle,
            'pictures (1/s)': pictures,
            'first picture, at most (ms)': first,
            'PSS (MB)': node_of(view).memory_full_info().pss / 1e6,
        }
    finally:
        for process in (view, ctrl, simu):
            process.send_signal(signal.SIGINT)
            process.wait()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--nb-robots', type=int, nargs='+', default=[8, 50, 250])
    parser.add_argument('--algo', default='traj_tracking')
    parser.add_argument('--duration', type=float, default=30.0)
    args = parsed(parser, nb_robots=[2], duration=3.0)
    print(f'{platform.platform()}, Python {platform.python_version()}, {os.cpu_count()} cores')
    with tempfile.TemporaryDirectory() as folder:
        for nb_robots in args.nb_robots:
            print(f'{nb_robots} robots under {args.algo}')
            figures = measure_view(nb_robots, args.algo, args.duration, Path(folder))
            for name, value in figures.items():
                print(f'  {name:36} {value:8.3f}', flush=True)


if __name__ == '__main__':
    main()
