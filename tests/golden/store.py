"""Golden files: what the code computes from fixed inputs, the same to the last digit.

    python tests/golden/store.py    write them again, after an intended change
    git diff tests/golden           show what changed

It uses the command line only, so that it survives any change of the modules. inputs/bag.mcap holds
two robots for 2 s, event-triggered on a ring, compressed by `mcap` with zstd.
inputs/foreign_mcap and inputs/foreign_sqlite3 hold the same 98 messages of a robot that is not of
this stack, written by rosbags: odometry, IMU, laser, joints, transforms, a text.
"""

from __future__ import annotations

import csv
import shutil
import sys
import tempfile
from collections.abc import Iterable
from importlib.metadata import entry_points
from pathlib import Path

import yaml

GOLDEN = Path(__file__).parent
INPUTS = GOLDEN / 'inputs'
NEAR = '--random-poses=box=2x2,distance=0.6'
RUNS = {
    'nav_wp': [
        '--algo=nav_wp', '--nb-robots=2', '--limits=burger', '--set=WPL=[[4.5, 4.5], [4, -4]]',
        '--duration=12',
    ],
    'traj_tracking': ['--algo=traj_tracking', '--nb-robots=2', '--vnom=1.5'],
    'consensus': ['--algo=consensus', '--nb-robots=4', '--set=K=0.8', '--vnom=1.5'],
    'leader_follower_formation': [
        '--algo=leader_follower_formation', '--nb-robots=4', '--vnom=2', '--komega=3',
    ],
    'leader_follower_distance_formation': [
        '--algo=leader_follower_distance_formation', '--nb-robots=4', '--vnom=2',
    ],
    'leader_election': [
        '--algo=leader_election', '--nb-robots=4', '--graph=path', '--loss=0.3', '--delay=0.25',
        '--seed=3', '--vnom=2', '--duration=4',
    ],
    'coverage': ['--algo=coverage', '--nb-robots=5', '--duration=4'],
    'ring': [
        '--algo=consensus', '--nb-robots=4', '--graph=ring', '--loss=0.3', '--delay=0.25',
        '--noise=0.02', '--seed=3', '--vnom=2',
    ],
    'event_triggered': [
        '--algo=consensus', '--nb-robots=4', '--event-triggered', '--threshold=0.15',
        '--delay=0.1', '--loss=0.1', '--random-poses', '--vnom=1',
    ],
    'filter': [
        '--algo=consensus', '--nb-robots=4', NEAR, '--filter=barrier', '--accel=1',
        '--arena=-2,2,-2,2', '--obstacles=disc 0.2 0.1 0.2', '--duration=8',
    ],
    'models': [
        '--algo=1:nav_wp,2-4:consensus', '--nb-robots=4',
        '--model=1:burger,2:car,3:omnidirectional', '--rate=7', '--robot-rate=14', '--vnom=0.2',
    ],
    'script': [
        f'--algo={INPUTS / "gather.py"}', '--nb-robots=4', f'--graph={INPUTS / "graph.yaml"}',
        '--range=9', '--set=K=0.9', '--seed=5', '--pose=2:1,0.5,1.57', '--duration=8',
    ],
}  # fmt: skip
"""Options of each run."""

BAGS = {'bag.mcap': 'bag', 'foreign_mcap': 'foreign_bag', 'foreign_sqlite3': 'foreign_bag'}
"""The golden files of each bag: the same messages in both formats have the same tables."""

SWEEP = [
    '--algo=consensus', '--nb-robots=3', '--graph=ring', '--vnom=2', '--duration=5',
    '--vary=K=0.5,1', '--vary=loss=0,0.3', '--seeds=2', '--no-plots', '--jobs=2',
]  # fmt: skip

_DURATION = '--duration=10'  # the default: of two, the last one counts


def setcmas(*arguments: object) -> None:
    """Run the command in this process."""
    (command,) = entry_points(group='console_scripts', name='setcmas')
    status = command.load()([str(argument) for argument in arguments])
    assert status == 0, arguments


def options(name: str) -> list[str]:
    """Return the options of a run."""
    return [_DURATION, *RUNS[name], '--no-plots']


def run(name: str, folder: Path) -> dict[str, bytes]:
    """Run offline; returns the tables and metrics by their names."""
    setcmas('offline', *options(name), '-o', folder / name)
    return results(folder / name)


def results(folder: Path) -> dict[str, bytes]:
    """Return the tables and metrics of a run by their names."""
    return _read([*(folder / 'csv').iterdir(), folder / 'metrics.yaml'])


def bag_tables(name: str, folder: Path) -> dict[str, bytes]:
    """Convert a bag of BAGS; returns the tables by their names."""
    setcmas('bag_to_csv', INPUTS / name, '-o', folder / name)
    return _read((folder / name).iterdir())


def sweep_table(folder: Path) -> dict[str, bytes]:
    """Run a sweep; returns the table of its runs."""
    setcmas('sweep', *SWEEP, '-o', folder / 'sweep')
    return _read([folder / 'sweep' / 'runs.csv'])


def marks(folder: Path) -> dict[str, bytes]:
    """Grade the class; returns the marks for spreadsheets, without remarks."""
    rubric = INPUTS / 'rubric.yaml'
    setcmas('grade', INPUTS / 'class', '--rubric', rubric, '-o', folder / 'marks', '--jobs', 2)
    with (folder / 'marks' / 'grades.csv').open(encoding='utf-8-sig') as file:
        rows = list(csv.DictReader(file))
    shown = [{key: text for key, text in row.items() if key != 'remarks'} for row in rows]
    return {'marks.yaml': yaml.safe_dump(shown, sort_keys=False, width=200).encode()}


def _read(paths: Iterable[Path]) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(paths)}


def stored(name: str) -> dict[str, bytes]:
    """Return golden files by their names: of a run, 'bag', 'foreign_bag', 'sweep' or 'marks'."""
    return _read((GOLDEN / 'files' / name).iterdir())


def main() -> None:
    """Write all golden files."""
    shutil.rmtree(GOLDEN / 'files', ignore_errors=True)
    with tempfile.TemporaryDirectory() as folder:
        made = {name: run(name, Path(folder)) for name in RUNS}
        made |= {golden: bag_tables(name, Path(folder)) for name, golden in BAGS.items()}
        made |= {'marks': marks(Path(folder)), 'sweep': sweep_table(Path(folder))}
    for name, files in made.items():
        target = GOLDEN / 'files' / name
        target.mkdir(parents=True)
        for file, content in files.items():
            (target / file).write_bytes(content)


if __name__ == '__main__':
    sys.exit(main())
