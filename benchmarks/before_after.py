"""Figures of two checkouts, measured side by side in one run; prints a table, asserts nothing.

Run in the environment that the newer one is installed in, on a quiet machine; the older one has an
environment of its own:

    python benchmarks/before_after.py OLD_PYTHON [--repeat 3] [--only offline]
"""

from __future__ import annotations

import argparse
import hashlib
import os
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from bag_to_csv import timed, write_bag
from fleet import measure_fleet, time_of_help
from quick_option import parsed
from tabulate import tabulate
from tqdm import tqdm

NB_ROBOTS = 8
LAWS = (
    'nav_wp',
    'traj_tracking',
    'consensus',
    'leader_follower_formation',
    'leader_follower_distance_formation',
)
SIMULATE = """
import sys, time
from setcmas_tools import simulate
nb_robots, options = int(sys.argv[1]), eval(sys.argv[2])
times = []
for _ in range(5):
    begin = time.perf_counter()
    simulate('consensus', nb_robots, 60.0, **options)
    times.append(time.perf_counter() - begin)
print(60.0 / min(times))
"""

Figures = dict[str, float]


def help_and_imports(python: Path, _: float) -> Figures:
    begin = time.perf_counter()
    subprocess.run([python, '-c', 'from setcmas_tools import simulate'], check=True)
    imported = time.perf_counter() - begin
    return {
        'setcmas --help (s)': statistics.median(time_of_help(setcmas(python)) for _ in range(5)),
        'import of simulate (s)': imported,
    }


def offline(python: Path, _: float) -> Figures:
    """Measure offline runs, with and without imperfect communication, and the whole command."""
    lossy = "{'graph': 'ring', 'loss': 0.1, 'delay': 0.2}"
    cases = {
        'offline, 8 robots (times real time)': ('8', '{}'),
        'offline, 20 robots (times real time)': ('20', '{}'),
        'offline, 8 robots, late and lossy (times real time)': ('8', lossy),
        'offline, 8 robots, event-triggered (times real time)': ('8', "{'event_triggered': True}"),
    }
    figures = {name: float(run(python, '-c', SIMULATE, *case)) for name, case in cases.items()}
    with tempfile.TemporaryDirectory() as folder:
        begin = time.perf_counter()
        run(setcmas(python), *offline_command('consensus', Path(folder) / 'out'))
        figures['setcmas offline of 60 s, with plots (s)'] = time.perf_counter() - begin
        begin = time.perf_counter()
        run(setcmas(python), 'csv_to_plot', str(Path(folder) / 'out'))
        figures['csv_to_plot (s)'] = time.perf_counter() - begin
    return figures


def bag_to_csv(python: Path, _: float) -> Figures:
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / 'bag'
        write_bag(bag, NB_ROBOTS, 20_000)
        return {'CSV of 20,000 messages (s)': min(timed(bag, setcmas(python)) for _ in range(3))}


def fleet(python: Path, duration: float) -> Figures:
    return measure_fleet(NB_ROBOTS, duration, setcmas(python))


def view(python: Path, duration: float) -> Figures:
    from view import measure_view

    with tempfile.TemporaryDirectory() as folder:
        return measure_view(NB_ROBOTS, 'traj_tracking', duration, Path(folder), setcmas(python))


BENCHMARKS: dict[str, Callable[[Path, float], Figures]] = {
    'help': help_and_imports,
    'offline': offline,
    'bag_to_csv': bag_to_csv,
    'fleet': fleet,
    'view': view,
}


def setcmas(python: Path) -> Path:
    """Return the command beside an interpreter."""
    return python.parent / 'setcmas'


def run(*command: str | Path) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def offline_command(algo: str, out: Path) -> list[str]:
    options = ['--nb-robots', str(NB_ROBOTS), '--duration', '60', '--output', str(out)]
    return ['offline', '--algo', algo, *options]


def trajectories(python: Path, algo: str) -> str:
    """Return a digest of the fleet.csv of an offline run."""
    with tempfile.TemporaryDirectory() as folder:
        run(setcmas(python), *offline_command(algo, Path(folder) / 'out'))
        return hashlib.sha256((Path(folder) / 'out/csv/fleet.csv').read_bytes()).hexdigest()


def measure(names: list[str], pythons: list[Path], repeat: int, duration: float) -> list[tuple]:
    """Return rows of the table: what, the medians before and after, all values."""
    values: dict[str, tuple[list[float], list[float]]] = {}
    for name in names:
        for round_ in tqdm(range(repeat), name, disable=None, leave=False):
            # Now the one, now the other is first.
            for side in (0, 1) if round_ % 2 == 0 else (1, 0):
                for what, value in BENCHMARKS[name](pythons[side], duration).items():
                    values.setdefault(what, ([], []))[side].append(value)
    return [row(what, before, after) for what, (before, after) in values.items()]


def row(what: str, before: list[float], after: list[float]) -> tuple[str, ...]:
    first, second = statistics.median(before), statistics.median(after)
    change = f'{100 * (second / first - 1):+.0f} %' if first else ''
    spread = f'{min(before):.4g} to {max(before):.4g}', f'{min(after):.4g} to {max(after):.4g}'
    return what, f'{first:.4g}', f'{second:.4g}', change, *spread


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('old_python', type=Path, help="interpreter of the older one's environment")
    parser.add_argument('--repeat', type=int, default=3)
    parser.add_argument('--duration', type=float, default=20.0, help='of fleet and view, s')
    parser.add_argument('--only', nargs='+', choices=[*BENCHMARKS, 'trajectories'])
    args = parsed(parser, repeat=1, only=['offline'])
    names = args.only or [*BENCHMARKS, 'trajectories']
    if 'view' in names and not shutil.which('chromium'):
        parser.error('view needs chromium and chromium-driver; leave it out with --only')
    pythons = [args.old_python.absolute(), Path(sys.executable)]
    print(f'{platform.platform()}, {os.cpu_count()} cores, Python {platform.python_version()}')
    timed_names = [name for name in names if name in BENCHMARKS]
    rows = measure(timed_names, pythons, args.repeat, args.duration)
    headers = ('median', 'before', 'after', 'change', 'all before', 'all after')
    print(tabulate(rows, headers, tablefmt='github', disable_numparse=True))
    for algo in LAWS if 'trajectories' in names else ():
        first, second = (trajectories(python, algo) for python in pythons)
        print(f'{algo}: {"equal to the last bit" if first == second else "NOT EQUAL"}')
    print(f'load at the end {os.getloadavg()[0]:.1f}')


if __name__ == '__main__':
    os.environ.pop('PYTHONDONTWRITEBYTECODE', None)  # each process would compile our modules anew
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        main()
