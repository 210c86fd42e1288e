"""Measures studies: rates of runs, two jobs against one; prints, asserts nothing.

python benchmarks/sweep.py [--repeat 5] [--duration 60] [--seeds 60] [--quick]

Rates are in times real time, of consensus with 8 robots for 60 s, all kinds of runs one after the
other in each repetition, as machines are noisy.
"""

from __future__ import annotations

import argparse
import os
import platform
import statistics
import time
from collections.abc import Callable

from offline import laws_alone
from quick_option import parsed

from setcmas_tools import simulate, sweep

NB_ROBOTS = 8
LINKS = {
    'ideal': {},
    'ring, delay 0.2, loss 0.2': {'graph': 'ring', 'delay': 0.2, 'loss': 0.2},
    'event-triggered': {'event_triggered': True},
}


def seconds(work: Callable[[], object]) -> float:
    """Return how long something takes in s."""
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def seconds_of_a_run(duration: float, seeds: int, jobs: int, given: dict[str, object]) -> float:
    """Return the time of one more run of a study in s; a study begins with about a second."""
    few, many = (
        seconds(lambda: sweep('consensus', NB_ROBOTS, duration, seeds=n, jobs=jobs, **given))  # noqa: B023
        for n in (2 * jobs, seeds + 2 * jobs)
    )
    return (many - few) / seeds


def kinds_of_runs(duration: float, seeds: int) -> dict[str, Callable[[], float]]:
    """Return functions that measure a run in s, by kind."""
    kinds = {'laws alone': lambda: laws_alone('consensus', NB_ROBOTS, duration)}
    for name, given in LINKS.items():
        kinds[f'simulate, {name}'] = lambda given=given: seconds(
            lambda: simulate('consensus', NB_ROBOTS, duration, **given)
        )
        for jobs in (1, 2):
            kinds[f'sweep, {jobs} jobs, {name}'] = lambda given=given, jobs=jobs: seconds_of_a_run(
                duration, seeds, jobs, given
            )
    return kinds


def main() -> None:
    """Print the medians of all kinds of runs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--repeat', type=int, default=5)
    parser.add_argument('--duration', type=float, default=60.0)
    parser.add_argument('--seeds', type=int, default=60)
    args = parsed(parser, repeat=1, duration=2.0, seeds=2)
    print(f'{platform.platform()}, {os.cpu_count()} cores, Python {platform.python_version()}')
    kinds = kinds_of_runs(args.duration, args.seeds)
    times: dict[str, list[float]] = {name: [] for name in kinds}
    for _ in range(args.repeat):
        for name, measure in kinds.items():
            times[name].append(measure())
    middle = {name: statistics.median(values) for name, values in times.items()}
    for name, one in middle.items():
        print(f'{name:45} {args.duration / one:7.0f} times real time, {1e3 * one:7.1f} ms a run')
    for name in LINKS:
        ratio = middle[f'sweep, 1 jobs, {name}'] / middle[f'sweep, 2 jobs, {name}']
        print(f'two jobs against one, {name:25} {ratio:.2f}')


if __name__ == '__main__':
    main()
