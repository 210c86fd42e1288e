"""Measures what the browser view costs while a browser looks; prints figures, asserts nothing.

Needs chromium and chromium-driver. Robots move under traj_tracking, the law that draws most. The
browser itself is not counted: without a graphics card it takes a core for the picture. Run in the
environment that setcmas is installed in, on a quiet machine:

    python benchmarks/view.py [--nb-robots 8 50] [--duration 30]
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
import viser
from browser import open_browser, wait_for_text
from websockets.sync.client import connect
from websockets.typing import Subprotocol

SETCMAS = Path(sys.executable).parent / 'setcmas'


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


def frames_per_s(url: str, duration: float) -> float:
    """Return how often the page is updated, as a second viewer counts it."""
    protocol = Subprotocol(f'viser-v{viser.__version__}')
    with connect(url.replace('http', 'ws'), subprotocols=[protocol], max_size=None) as socket:
        socket.recv()  # what there is already
        time.sleep(0.5)
        count, begin = 0, time.monotonic()
        while time.monotonic() - begin < duration:
            socket.recv()
            count += 1
        return count / (time.monotonic() - begin)


def measure_view(
    nb_robots: int, algo: str, duration: float, folder: Path, setcmas: Path = SETCMAS
) -> dict[str, float]:
    """Let a browser look at a fleet for a while, and return figures by name."""
    simu = start(folder / 'simu', setcmas, 'simu', '--nb-robots', str(nb_robots))
    ctrl = start(folder / 'ctrl', setcmas, 'ctrl', '--algo', algo)
    view = start(folder / 'view', setcmas, 'view')
    try:
        url = url_in(folder / 'view')
        time.sleep(5)
        idle = load(node_of(view), 5)
        with open_browser(400, 300) as browser:
            browser.get(url)
            wait_for_text(browser, f'{nb_robots} robots')
            time.sleep(5)
            busy = load(node_of(view), duration)
            frames = frames_per_s(url, 5)
        return {
            'view with a browser (core)': busy,
            'view without a browser (core)': idle,
            'view updates (1/s)': frames,
            'view PSS (MB)': node_of(view).memory_full_info().pss / 1e6,
        }
    finally:
        for process in (view, ctrl, simu):
            process.send_signal(signal.SIGINT)
            process.wait()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--nb-robots', type=int, nargs='+', default=[8, 50])
    parser.add_argument('--algo', default='traj_tracking')
    parser.add_argument('--duration', type=float, default=30.0)
    args = parser.parse_args()
    print(f'{platform.platform()}, Python {platform.python_version()}, {os.cpu_count()} cores')
    with tempfile.TemporaryDirectory() as folder:
        for nb_robots in args.nb_robots:
            print(f'{nb_robots} robots under {args.algo}')
            figures = measure_view(nb_robots, args.algo, args.duration, Path(folder))
            for name, value in figures.items():
                print(f'  {name:36} {value:8.3f}', flush=True)


if __name__ == '__main__':
    main()
