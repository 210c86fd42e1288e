"""Measures offline runs against real time and against the laws alone, in time of one core.

python benchmarks/offline.py [--repeat 7] [--quick]
"""

from __future__ import annotations

import argparse
import os
import platform
import statistics
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.communication.graph import complete
from setcmas_simu.fleet.fleet import start_poses
from setcmas_tools.offline.offline_fleet import FleetLaws
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.run.scenario import Scenario

CONTROL_RATE_HZ = 5


def two_neighbours(robotNo, nbRobots, poses, t):
    """Cyclic pursuit of two neighbours: a law that is cheap in any fleet."""
    me, first, second = robotNo - 1, robotNo % nbRobots, (robotNo + 1) % nbRobots
    vx = 0.5 * (0.5 * (poses[0, first] + poses[0, second]) - poses[0, me])
    vy = 0.5 * (0.5 * (poses[1, first] + poses[1, second]) - poses[1, me])
    return vx, vy


class Bare(NamedTuple):
    """The function of a law, without the checks of what it returns."""

    function: Callable[..., Any]
    robot: int
    nb_robots: int

    def __call__(self, poses, t):
        return self.function(self.robot, self.nb_robots, poses, t)


def laws_alone(algo, nb_robots: int, duration: float) -> float:
    """Return how long the bare functions keep a core busy, called in a plain loop, in s."""
    chosen = Scenario.of(algo, nb_robots=nb_robots).law
    laws = [
        Bare(law._control.function, law.robot, nb_robots)
        for law in FleetLaws(chosen, nb_robots).laws
    ]
    poses, adjacency = start_poses(nb_robots), complete(nb_robots)
    begin = time.process_time()
    for k in range(round(duration * CONTROL_RATE_HZ)):
        for law in laws:
            with network.LawCall(law.robot, adjacency):
                law(poses, k / CONTROL_RATE_HZ)
    return time.process_time() - begin


def measure(algo, nb_robots: int, duration: float, repeat: int, **options) -> None:
    """Print the medians for one case, whose options go to `simulate`."""
    whole, alone = [], []
    for _ in range(repeat):  # side by side, because machines are noisy
        begin = time.process_time()
        run = simulate(algo, nb_robots, duration, **options)
        whole.append(time.process_time() - begin)
        alone.append(laws_alone(algo, nb_robots, duration))
        assert np.isfinite(run.poses).all()
    name = algo if isinstance(algo, str) else algo.__name__
    name += ''.join(f' {option}={value}' for option, value in options.items())
    total, laws = statistics.median(whole), statistics.median(alone)
    print(
        f'{name:42} {nb_robots:5} robots {duration:4g} s: {duration / total:7.0f} x real time, '
        f'{1e3 * total:7.1f} ms; laws alone {duration / laws:7.0f} x; '
        f'overhead {100 * (total / laws - 1):4.0f} %'
    )


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--repeat', type=int, default=7)
    parser.add_argument('--quick', action='store_true', help='one run of 2 s a case')
    args = parser.parse_args()
    repeat, duration = (1, 2) if args.quick else (args.repeat, 60)
    print(f'{platform.platform()}, {os.cpu_count()} cores, Python {platform.python_version()}')
    measure('consensus', 8, duration, repeat)
    measure('consensus', 8, duration, repeat, graph='ring', delay=0.2, loss=0.3)
    measure('consensus', 8, duration, repeat, event_triggered=True)
    measure('consensus', 20, duration, repeat)
    measure(two_neighbours, 1000, duration, min(repeat, 3))


if __name__ == '__main__':
    main()
