"""Measures offline runs against real time and against the laws alone; prints, asserts nothing.

python tests/benchmarks/offline.py [--repeat 5]
"""

from __future__ import annotations

import argparse
import os
import platform
import statistics
import time

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.communication.graph import complete
from setcmas_simu.fleet.fleet import start_poses
from setcmas_tools.offline.engine import simulate
from setcmas_tools.offline.fleet_laws import load_laws

CONTROL_RATE_HZ = 5


def two_neighbours(robotNo, nbRobots, poses, t):
    """Cyclic pursuit of two neighbours: a law that is cheap in any fleet."""
    me, first, second = robotNo - 1, robotNo % nbRobots, (robotNo + 1) % nbRobots
    vx = 0.5 * (0.5 * (poses[0, first] + poses[0, second]) - poses[0, me])
    vy = 0.5 * (0.5 * (poses[1, first] + poses[1, second]) - poses[1, me])
    return vx, vy


def laws_alone(algo, nb_robots: int, duration: float) -> float:
    """Return how long the bare functions take, called in a plain loop, in s."""
    functions = [law._control for law in load_laws(algo, nb_robots)]
    poses = start_poses(nb_robots)
    begin = time.perf_counter()
    for k in range(round(duration * CONTROL_RATE_HZ)):
        for robot, function in enumerate(functions, start=1):
            network.begin_call(robot, complete(nb_robots))
            function(robot, nb_robots, poses, k / CONTROL_RATE_HZ)
    return time.perf_counter() - begin


def measure(algo, nb_robots: int, duration: float, repeat: int) -> None:
    """Print the medians for one case."""
    whole, alone = [], []
    for _ in range(repeat):  # side by side, because machines are noisy
        begin = time.perf_counter()
        run = simulate(algo, nb_robots, duration)
        whole.append(time.perf_counter() - begin)
        alone.append(laws_alone(algo, nb_robots, duration))
        assert np.isfinite(run.poses).all()
    name = algo if isinstance(algo, str) else algo.__name__
    total, laws = statistics.median(whole), statistics.median(alone)
    print(
        f'{name:16} {nb_robots:5} robots {duration:4g} s: {duration / total:7.0f} x real time, '
        f'{1e3 * total:7.1f} ms; laws alone {duration / laws:7.0f} x; '
        f'overhead {100 * (total / laws - 1):4.0f} %'
    )


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--repeat', type=int, default=7)
    repeat = parser.parse_args().repeat
    print(f'{platform.platform()}, {os.cpu_count()} cores, Python {platform.python_version()}')
    measure('consensus', 8, 60, repeat)
    measure('consensus', 20, 60, repeat)
    measure(two_neighbours, 1000, 60, min(repeat, 3))


if __name__ == '__main__':
    main()
