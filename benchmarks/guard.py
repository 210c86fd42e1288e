"""Measures what guards cost: an emulated lab with and without.

Run in the environment that setcmas is installed in, on a quiet machine:

    python benchmarks/guard.py [--robots 2] [--repeat 3] [--seconds 8]
"""

import argparse
import contextlib
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

import psutil
from tabulate import tabulate

sys.path.insert(0, str(Path(__file__).parents[1] / 'tests'))
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

from quick_option import parsed
from ros_domain import reserved_domain

SETTLES_S = 4.0
LAB, BRIDGES = (
    [sys.executable, '-m', f'setcmas_expe.{module}']
    for module in ('emulation.emulated_lab', 'bridges')
)


@contextlib.contextmanager
def running(command):
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        try:
            yield psutil.Process(process.pid)
            assert process.poll() is None, f'{command} has ended'
        finally:
            process.terminate()


def share(process, seconds):
    """Return the share of a core that a process takes."""
    before = sum(process.cpu_times()[:2])
    time.sleep(seconds)
    return (sum(process.cpu_times()[:2]) - before) / seconds


def lab(robots, seconds, *options):
    told = ['--nb-robots', str(robots), *options]
    with running([*LAB, *told]) as process, running([*BRIDGES, *told]):
        time.sleep(SETTLES_S)
        return share(process, seconds)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--robots', type=int, default=2)
    parser.add_argument('--repeat', type=int, default=3)
    parser.add_argument('--seconds', type=float, default=8.0)
    args = parsed(parser, robots=1, repeat=1, seconds=2.0)
    kinds = {
        f'lab of {args.robots}, without guards': lambda: lab(
            args.robots, args.seconds, '--without-guard'
        ),
        f'lab of {args.robots}, guarded': lambda: lab(args.robots, args.seconds),
    }
    shares = {name: [] for name in kinds}
    with reserved_domain() as domain:
        os.environ['ROS_DOMAIN_ID'] = str(domain)
        for _ in range(args.repeat):
            for name, measure in kinds.items():
                shares[name].append(measure())
    rows = [(name, f'{statistics.median(found):.3f}') for name, found in shares.items()]
    print(tabulate(rows, ('process', 'core (median)'), tablefmt='github'))


if __name__ == '__main__':
    main()
