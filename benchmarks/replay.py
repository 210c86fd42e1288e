"""Measures the page of a long run; prints figures, asserts nothing.

The run is made offline first. Without a browser: what a picture costs, as its arrays are sent.

    python benchmarks/replay.py [--nb-robots 50] [--duration 600]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil

from setcmas_tools import Run, simulate
from setcmas_tools.view.page.page import Page
from setcmas_tools.view.replay.main import ReplayView
from setcmas_tools.view.replay.options import ReplayOptions

FRAMES = 100


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument('--nb-robots', type=int, default=50)
    parser.add_argument('--duration', type=float, default=600.0)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'run'
        ring = {'graph': 'ring', 'event_triggered': True}
        simulate('traj_tracking', args.nb_robots, args.duration, **ring).save(path)
        measure(path)


def measure(path: Path) -> None:
    process = psutil.Process()
    memory = process.memory_info().rss
    begin = time.perf_counter()
    run = Run.load(path)
    loaded = time.perf_counter()
    page = Page('127.0.0.1', 8950)
    try:
        view = ReplayView(page, {'run': run}, ReplayOptions())
        view.show(0.0)
        shown = time.perf_counter()
        grown = (process.memory_info().rss - memory) / 1e6
        print(f'{len(run.robots)} robots, {run.table.t[-1]:g} s, {len(run.table.t):,} rows:')
        print(f'read in {loaded - begin:.2f} s, page in {shown - loaded:.2f} s, {grown:.0f} MB')
        end = float(run.table.t[-1])
        tell('played', [frame(view, t) for t in 0.5 * end + 0.05 * np.arange(FRAMES)])
        random = np.random.default_rng(1).uniform(0.0, end, FRAMES)
        tell('scrubbed', [frame(view, t) for t in random])
        view._robot._list.value = 'robot 1'
        tell('scrubbed, one robot chosen', [frame(view, t) for t in random[::-1]])
    finally:
        page.stop()


def frame(view: ReplayView, t: float) -> float:
    """Return how long a picture takes in ms."""
    begin = time.perf_counter()
    view.show(float(t))
    return 1000 * (time.perf_counter() - begin)


def tell(what: str, durations: list[float]) -> None:
    middle, worst = np.median(durations), max(durations)
    print(f'{what}: median {middle:.1f} ms a picture, at most {worst:.1f} ms')


if __name__ == '__main__':
    main()
