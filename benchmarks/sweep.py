"""Measures studies: rates of runs, two workers against one, memory; prints, asserts nothing.

python benchmarks/sweep.py [--repeat 5] [--runs 10000] [--robotarium PATH]

Rates are in times real time, of consensus with 8 robots for 60 s, all kinds of runs one after the
other in each repetition, as machines are noisy.
"""

from __future__ import annotations

import argparse
import importlib
import os
import platform
import statistics
import sys
import threading
import time
from collections.abc import Callable

import numpy as np
import psutil
from offline import laws_alone

from setcmas_tools import simulate, sweep

NB_ROBOTS, DURATION = 8, 60.0
LINKS = {
    'ideal': {},
    'ring, delay 0.2, loss 0.2': {'graph': 'ring', 'delay': 0.2, 'loss': 0.2},
    'event-triggered': {'event_triggered': True},
}
SEEDS = 60
"""Runs of a study that is timed; a study begins with about a second without any."""


def seconds(work: Callable[[], object]) -> float:
    """Return how long something takes in s."""
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def seconds_of_a_run(given: dict[str, object], jobs: int) -> float:
    """Return the time of one more run of a study in s."""
    few, many = (
        seconds(lambda: sweep('consensus', NB_ROBOTS, DURATION, seeds=n, jobs=jobs, **given))  # noqa: B023
        for n in (2 * jobs, SEEDS + 2 * jobs)
    )
    return (many - few) / SEEDS


def robotarium(path: str) -> float:
    """Return how long the Robotarium's simulator takes for the same consensus in s."""
    sys.path.insert(0, path)
    simulators = importlib.import_module('rps.robotarium')
    transformations = importlib.import_module('rps.utilities.transformations')
    start = np.array([[1.0, 1, -1, -1, 0, 1, 0, -1], [1, -1, -1, 1, 1, 0, -1, 0], [0] * 8])
    simulator = simulators.Robotarium(
        number_of_robots=NB_ROBOTS, show_figure=False, sim_in_real_time=False,
        initial_conditions=0.8 * start,
    )  # fmt: skip
    to_unicycle = transformations.create_si_to_uni_dynamics()

    def run() -> None:
        for _ in range(round(DURATION / 0.033)):
            poses = simulator.get_poses()
            gaps = poses[:2].mean(axis=1, keepdims=True) - poses[:2]
            simulator.set_velocities(np.arange(NB_ROBOTS), to_unicycle(0.5 * gaps, poses))
            simulator.step()

    return seconds(run)


def rates(repeat: int, path: str | None) -> None:
    """Print the medians of all kinds of runs."""
    kinds: dict[str, Callable[[], float]] = {
        'laws alone': lambda: laws_alone('consensus', NB_ROBOTS, DURATION)
    }
    for name, given in LINKS.items():
        kinds[f'simulate, {name}'] = lambda given=given: seconds(
            lambda: simulate('consensus', NB_ROBOTS, DURATION, **given)
        )
        for jobs in (1, 2):
            kinds[f'sweep, {jobs} jobs, {name}'] = lambda given=given, jobs=jobs: seconds_of_a_run(
                given, jobs
            )
    if path:
        kinds['Robotarium'] = lambda: robotarium(path)
    times: dict[str, list[float]] = {name: [] for name in kinds}
    for _ in range(repeat):
        for name, measure in kinds.items():
            times[name].append(measure())
    middle = {name: statistics.median(values) for name, values in times.items()}
    for name, one in middle.items():
        print(f'{name:45} {DURATION / one:7.0f} times real time, {1e3 * one:7.1f} ms a run')
    for name in LINKS:
        ratio = middle[f'sweep, 1 jobs, {name}'] / middle[f'sweep, 2 jobs, {name}']
        print(f'two workers against one, {name:25} {ratio:.2f}')


def memory(runs: int) -> None:
    """Print the memory of a study of short runs as it goes on: its own, and its processes'."""
    me, seen = psutil.Process(), []
    ended = threading.Event()

    def watch() -> None:
        while not ended.wait(1.0):
            below = 0
            for child in me.children(recursive=True):
                try:
                    below += child.memory_full_info().pss
                except psutil.Error:
                    continue  # a copy that has ended meanwhile
            seen.append((me.memory_info().rss / 2**20, below / 2**20))

    watcher = threading.Thread(target=watch)
    watcher.start()
    taken = seconds(lambda: sweep('consensus', 2, 2.0, seeds=runs, jobs=2, random_poses='auto'))
    ended.set()
    watcher.join()
    parts = [seen[len(seen) * k // 10] for k in range(10)] + [seen[-1]]
    print(f'{runs} runs of 2 robots for 2 s: {taken:.0f} s, {1e3 * taken / runs:.1f} ms each')
    print('MB at each tenth: ' + ', '.join(f'{own:.0f} + {below:.0f}' for own, below in parts))


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--repeat', type=int, default=5)
    parser.add_argument('--runs', type=int, default=0, help='watch the memory of so many runs')
    parser.add_argument('--robotarium', metavar='PATH', help="a checkout of its simulator's code")
    args = parser.parse_args()
    print(f'{platform.platform()}, {os.cpu_count()} cores, Python {platform.python_version()}')
    if args.runs:
        memory(args.runs)
    if args.repeat:
        rates(args.repeat, args.robotarium)


if __name__ == '__main__':
    main()
