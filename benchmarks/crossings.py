"""Random crossings under the safety filter: least separation, and who arrives; time of a step.

python benchmarks/crossings.py --runs 1000
python benchmarks/crossings.py --steps
"""

from __future__ import annotations

import argparse
import itertools
import math
import time

import numpy as np
from joblib import Parallel, delayed
from quick_option import parsed

from setcmas_ctrl.filter.filter_options import FilterOptions, Verdict
from setcmas_ctrl.laws.control_options import GainOptions
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.start_poses import RandomPoses
from setcmas_simu.robots.unicycle import UNICYCLE
from setcmas_tools import simulate
from setcmas_tools.measures.safety_metrics import separation
from setcmas_tools.offline.offline_fleet import Commander
from setcmas_tools.run.fleet_motion import on_grid

SEPARATION_M = 0.35
ARRIVED_M = 0.1
BOX = RandomPoses.of('box=3x3,distance=0.5')


def places(seed: int, circle: bool) -> tuple[Floats, Floats]:
    """Return start poses and goals: at random, or across a circle of a random radius."""
    if not circle:
        return BOX.draw(8, seed, {}), BOX.draw(8, seed + 10_000_000, {})
    angles = np.arange(8) * np.pi / 4
    radius = np.random.default_rng(seed).uniform(1.0, 2.0)
    start = np.stack([radius * np.cos(angles), radius * np.sin(angles), angles + np.pi])
    return start, -start


def crossing(
    seed: int, model: str, turn: float, duration: float, circle: bool
) -> tuple[float, int, int]:
    """Let 8 robots change places; returns least separation, who arrived, unsolved steps.

    Their law heads `turn` degrees to the right of the goal.
    """
    start, goals = places(seed, circle)
    cos, sin = math.cos(math.radians(turn)), math.sin(math.radians(turn))

    def control(robotNo, nbRobots, poses, t):
        x, y = goals[:2, robotNo - 1] - poses[:2, robotNo - 1]
        return cos * x + sin * y, cos * y - sin * x

    run = simulate(
        control, 8, duration, poses=start, model=model, filter='barrier',
        min_separation=SEPARATION_M, warn=lambda _: None,
    )  # fmt: skip
    found = separation(on_grid(run.table, 10.0))
    left = np.hypot(*(run.poses[-1, :2] - goals[:2]))
    unsolved = run.commands.verdict == Verdict.NO_SOLUTION
    return found.least_separation_m, int((left < ARRIVED_M).sum()), int(unsolved.sum()) // 8


def step_time(nb_robots: int, jam: bool) -> float:
    """Return the median time of a step in ms of robots that cross, or all want to the middle."""
    side = 2.4 * SEPARATION_M * np.sqrt(nb_robots)
    box = RandomPoses.of(f'box={side:g}x{side:g},distance=0.5')
    poses, goals = box.draw(nb_robots, 0, {}), box.draw(nb_robots, 1, {})[:2]
    goals *= not jam
    commander = Commander(GainOptions(), FilterOptions(filter='barrier'), nb_robots, len)
    commander.use([UNICYCLE] * nb_robots)
    times = []
    for _ in range(150):
        begin = time.perf_counter()
        commands = commander(goals - poses[:2], poses).commands
        times.append(time.perf_counter() - begin)
        poses = UNICYCLE.step(UNICYCLE.start(poses), commands, 0.2)[:3]
    return 1e3 * float(np.median(times))


def print_step_times() -> None:
    """Print the median time of a step for fleets of three sizes."""
    for nb_robots in (8, 20, 50):
        crossing_ms, jam_ms = (step_time(nb_robots, jam) for jam in (False, True))
        print(
            f'{nb_robots} robots, a step (median): {crossing_ms:.2f} ms while they cross, '
            f'{jam_ms:.2f} ms in one jam'
        )


def print_crossings(nb_runs: int, duration: float) -> None:
    """Print the table of crossings, a row for each kind."""
    print('| robots | places | turn (deg) | runs | least distance | all arrive | unsolved steps |')
    print('|---|---|---|---|---|---|---|')
    for circle, model, turn in itertools.product(
        (False, True), ('omnidirectional', 'unicycle'), (0, 20)
    ):
        results = Parallel(n_jobs=2)(
            delayed(crossing)(seed, model, turn, duration, circle) for seed in range(nb_runs)
        )
        least, arrived, unsolved = map(np.array, zip(*results, strict=True))
        print(
            f'| {model} | {"circle" if circle else "random"} | {turn} | {nb_runs:,} '
            f'| {least.min():.3f} m | {(arrived == 8).mean() * 100:.1f} % | {unsolved.sum()} |',
            flush=True,
        )


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--runs', type=int, default=1000)
    parser.add_argument('--duration', type=float, default=30.0)
    parser.add_argument('--steps', action='store_true', help='the time of a step only')
    args = parsed(parser, runs=2, duration=5.0)
    if args.steps:
        print_step_times()
    else:
        print_crossings(args.runs, args.duration)


if __name__ == '__main__':
    main()
