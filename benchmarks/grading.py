"""Grades a class of generated submissions: time, equal bytes, order of the marks; prints a table.

python benchmarks/grading.py [--students 100] [--scenarios 5] [--jobs 2] [--once] [--keep DIR]

100 submissions in five scenarios are to take at most 180 s with two jobs on two free cores. With
--once, the class is graded once; otherwise a second time and with one job, to compare the files.

Submissions are consensus laws of mixed quality: gains from 0.05 to 0.5 1/s, whose disagreement
falls like exp(-K t), so that more gain is to get more points; and mistakes, which are to get less
than all of these. Some hang, die or write without end, as in any class.
"""

from __future__ import annotations

import argparse
import filecmp
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import msgspec
import numpy as np
from quick_option import parsed

from setcmas_ctrl.laws.script_loader import EXERCISES
from setcmas_tools.grade.class_grading import KEPT
from setcmas_tools.grade.mark_records import Marks
from setcmas_tools.submissions.sandbox import obstacle

SCENARIOS = (
    'nb_robots: 8, duration: 20',
    'nb_robots: 3, duration: 20, random_poses: auto, seed: 2',
    'nb_robots: 5, duration: 20, graph: ring',
    'nb_robots: 8, duration: 20, graph: ring, delay: 0.1, loss: 0.1',
    'nb_robots: 12, duration: 20, random_poses: auto, seed: 7',
)
CRITERION = '{metric: disagreement, at_most: 0.001, none_at: 4, points: 2}'
TERM = 'v -= K / nbRobots * (p - positions[:, j]) * positions[:, j].any()  # known robots only'
MISTAKES = {
    'sign': ('v -=', 'v +='),
    'column': ('robotNo - 1', 'robotNo - 2'),
    'error': ('return v[0]', 'return v[2]'),
    'nothing': ('v -=', 'v -= 0 *'),
    'loop': ('    return v', '    while t > 5: pass\n    return v'),
    'exit': ('    return v', '    import os\n    if t > 5: os._exit(0)\n    return v'),
    'memory': ('    return v', '    rest = [0]\n    while t > 5: rest += rest\n    return v'),
    'output': ('    return v', '    print("x" * 100_000)\n    return v'),
}
"""What takes a good law's place; all but the last get less than any gain."""


def write_class(folder: Path, students: int) -> dict[str, float]:
    """Write submissions; returns the gain of each that is right, by its name."""
    law = EXERCISES.file('consensus').read_text().replace('pass', TERM)
    law = law.replace('v = np.zeros(2)', 'v, positions = np.zeros(2), np.nan_to_num(positions)')
    folder.mkdir(parents=True)
    for name, (right, wrong) in MISTAKES.items():
        assert right in law, name
        (folder / f'mistake_{name}.py').write_text(law.replace(right, wrong))
    gains = {}
    for number, gain in enumerate(np.geomspace(0.05, 0.5, students - len(MISTAKES))):
        gains[f'student_{number:03}.py'] = float(gain)
        own = law.replace('K = 0.5', f'K = {gain:.4f}')
        (folder / f'student_{number:03}.py').write_text(own)
    return gains


def graded(place: Path, output: str, jobs: int) -> tuple[list[Marks], str]:
    """Grade the class in a folder; return the marks, and the wall-clock and processor time."""
    begin, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        ['setcmas', 'grade', 'class', '-R', 'rubric.yaml', '-o', output, '--jobs', str(jobs),
         '--call-timeout', '2'],
        cwd=place, check=True, stdout=subprocess.DEVNULL,
    )  # fmt: skip
    seconds, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    user, system = after.ru_utime - before.ru_utime, after.ru_stime - before.ru_stime
    files = (place / output / KEPT).iterdir()
    marks = [msgspec.json.decode(file.read_bytes(), type=Marks) for file in files]
    return (
        marks,
        f'{seconds:.0f} s ({user:.0f} s of the processor, and {system:.0f} s in the kernel)',
    )


def different(first: Path, second: Path) -> list[str]:
    """Return the files that differ between two folders."""
    names = {str(f.relative_to(one)) for one in (first, second) for f in one.rglob('*.*')}
    _, mismatch, errors = filecmp.cmpfiles(first, second, names, shallow=False)
    return mismatch + errors


def report(place: Path, students: int, nb_scenarios: int, jobs: int, once: bool) -> None:
    """Grade a class with several jobs, unless once also again and with one job; print results."""
    load, _, _ = os.getloadavg()
    gains = write_class(place / 'class', students)
    scenarios = ''.join(
        f'  - {{name: scenario {k}, {one}, criteria: [{CRITERION}]}}\n'
        for k, one in enumerate(SCENARIOS[:nb_scenarios], 1)
    )
    (place / 'rubric.yaml').write_text(f'exercise: consensus\nscenarios:\n{scenarios}')
    marks, seconds = graded(place, 'grades', jobs)
    scores = {one.submission: one.score for one in marks}
    right = [scores[name] for name in gains]
    wrong = [score for name, score in scores.items() if name not in gains and 'output' not in name]
    print(f'{platform.machine()}, Python {platform.python_version()}')
    print(f'load before: {load:.1f}; bubblewrap: {not obstacle()}')
    print(f'{students} submissions, {nb_scenarios} scenarios, {jobs} jobs: {seconds}')
    for other, number in () if once else (('again', jobs), ('alone', 1)):
        _, seconds = graded(place, other, number)
        differing = len(different(place / 'grades', place / other))
        print(f'  {other}, {number} jobs: {seconds}; files that differ: {differing}')
    print(f'  marks rise with the gain: {right == sorted(right)}, {right[0]} to {right[-1]}')
    print(f'  mistakes get less: {max(wrong) < right[0]}, {max(wrong)} at most')


def main() -> None:
    """Read the options and report."""
    parser = argparse.ArgumentParser(description=__doc__.partition('\n')[0])
    parser.add_argument('--students', type=int, default=100)
    parser.add_argument('--scenarios', type=int, default=len(SCENARIOS))
    parser.add_argument('--jobs', type=int, default=2)
    parser.add_argument('--once', action='store_true', help='do not repeat and compare')
    parser.add_argument('--keep', type=Path, help='folder for the class and its grades')
    args = parsed(parser, students=10, scenarios=1, once=True)
    with tempfile.TemporaryDirectory() as folder:
        report(args.keep or Path(folder), args.students, args.scenarios, args.jobs, args.once)


if __name__ == '__main__':
    sys.exit(main())
