"""How fast runs over ROS in lockstep are, and whether they are those of `setcmas offline`.

    python benchmarks/lockstep.py --nb-robots 1 8 20 50 --duration 60

The start is left out: a run of a tenth of a second takes it alone. Cores are those of all
processes together, the conversion to CSV too.
"""

import argparse
import filecmp
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SETCMAS = [Path(sys.executable).parent / 'setcmas']


def measured(verb, nb_robots, duration, folder, *further):
    """Run a verb; return the time in s that it takes, and that of the processors."""
    options = ['--algo', 'consensus', '--nb-robots', nb_robots, '--duration', duration]
    command = [*SETCMAS, *verb, *map(str, options), '--no-plots', '--overwrite', '-o', folder]
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    subprocess.run([*command, *further], check=True, capture_output=True)
    wall, after = time.monotonic() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--nb-robots', type=int, nargs='+', default=[1, 8, 20, 50])
    parser.add_argument('--duration', type=float, default=60.0)
    parser.add_argument('--quick', action='store_true', help='little of everything: a test of it')
    args, further = parser.parse_known_args()
    if args.quick:
        args.nb_robots, args.duration = [2], 3.0
    print(f'{"robots":>6} {"start (s)":>10} {"times real time":>16} {"cores":>6}  fleet.csv')
    for nb_robots in args.nb_robots:
        with tempfile.TemporaryDirectory() as text:
            folder = Path(text)
            lockstep = ['run', '--lockstep']
            start, start_cpu = measured(lockstep, nb_robots, 0.1, folder / 'ros', *further)
            wall, cpu = measured(lockstep, nb_robots, args.duration, folder / 'ros', *further)
            measured(['offline'], nb_robots, args.duration, folder / 'offline', *further)
            tables = [folder / name / 'csv' / 'fleet.csv' for name in ('ros', 'offline')]
            same = 'the same' if filecmp.cmp(*tables, shallow=False) else 'DIFFERS'
        rate, cores = args.duration / (wall - start), (cpu - start_cpu) / (wall - start)
        print(f'{nb_robots:6} {start:10.1f} {rate:16.0f} {cores:6.2f}  {same}', flush=True)


if __name__ == '__main__':
    main()
