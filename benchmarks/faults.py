"""Injects every kind of fault into a rehearsed experiment; prints how robots stop, and stay.

Run in the environment that setcmas is installed in, on a quiet machine, as root for the network;
two at a time take some 15 minutes on 2 cores:

    python benchmarks/faults.py --jobs 2 [--repeat 3] [--only 'mocap nan']
"""

from __future__ import annotations

import argparse
import itertools
import os
import platform
import re
import signal
import sys
import traceback
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from multiprocessing.pool import ThreadPool
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / 'tests'))
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

from fault_kinds import (
    arena,
    guards,
    mocap,
    network,
    people,
    processes,
    rogues,
    scripts,
)
from fault_kinds.kind import Kind
from fault_places import rehearsal
from network_namespaces import NoNetworkError, in_a_process
from quick_option import parsed
from rehearsal import STANDS_S, Rehearsal
from ros_domain import reserved_domain
from tabulate import tabulate
from tqdm import tqdm

MOST_S, MOST_M = 0.7, 0.16
LASTS_S = 1.5
"""For how long a fault lasts after the stop, in s, before its cause is taken away."""
WATCHED_S = 4.0
"""For how long robots are watched after that, in s: they must not set off again."""
CREEPS_M_S = 0.005
LONGEST_S = 180
STATUS = re.compile(r'RUNNING|STARTING|STOPPED|PAUSED|STOP HELD|\[lab\] robot \d+, for')

KINDS: dict[str, Kind] = {
    name: kind
    for room in (processes, scripts, mocap, arena, guards, people, rogues, network)
    for name, kind in room.KINDS.items()
}


@dataclass(frozen=True)
class Result:
    """What became of a fault: the worst of its robots, and the line that reports it.

    `again` is how far the wheels of a robot turned after it had stopped, in m.
    """

    seconds: float
    metres: float
    again: float
    line: str

    def is_well(self, kind: Kind) -> bool:
        stays = kind.lets_go or not self.again
        reported = bool(self.line) or not kind.line
        soon = self.seconds <= MOST_S or not kind.moving
        return soon and self.metres < MOST_M and stays and reported


def measured(name: str) -> Result:
    """Inject a fault, in a domain of its own."""
    kind = KINDS[name]
    signal.signal(signal.SIGALRM, _give_up)
    signal.alarm(LONGEST_S)
    with reserved_domain() as domain, rehearsal(kind, domain) as running:
        if kind.moving:
            running.let_go()
            running.peer.spin(1.0)
        before = len(running.output())
        fault = kind.inject(running)
        stops = kind.stops(running, fault)
        running.peer.spin(LASTS_S)
        kind.undo(running)
        running.peer.spin(WATCHED_S)
        rest = fault + max(stop.seconds for stop in stops) + STANDS_S
        return Result(
            max(stop.seconds for stop in stops),
            max(stop.metres for stop in stops),
            _rolled_again(running, rest),
            _line(running.output()[before:], kind),
        )


def _give_up(*_: object) -> None:
    raise AssertionError(f'it takes longer than {LONGEST_S} s')


def _rolled_again(running: Rehearsal, rest: float) -> float:
    """Return how far the wheels of a robot have turned since all rested, in m; 0 if they rest."""
    return max(
        sum(
            truth.rolls * (truth.stamp - before.stamp)
            for before, truth in itertools.pairwise(samples)
            if truth.stamp > rest and truth.rolls > CREEPS_M_S
        )
        for samples in running.truth.values()
    )


def _line(output: str, kind: Kind) -> str:
    """Return the first line that reports the fault, without lines of states and injections."""
    lines = [line for line in output.splitlines() if not STATUS.match(line)]
    found = [line for line in lines if kind.line and re.search(kind.line, line)]
    if kind.line and not found:
        print(f"no line has '{kind.line}':", *lines, sep='\n  ')
    return found[0].strip() if found else ''


def row(repeat: int, name: str) -> tuple[str, ...]:
    """Measure a fault several times; returns a line of the table with the worst values."""
    try:
        results = [in_a_process(measured, name) for _ in range(repeat)]
    except (AssertionError, NoNetworkError):
        traceback.print_exc()
        return name, 'not measured', '', '', '', 'NO'
    ways = [result.again for result in results if result.again]
    again = f'{len(ways)} of {repeat}' + (f', {max(ways):.3f} m' if ways else '')
    return (
        name,
        f'{max(result.seconds for result in results):.2f}',
        f'{max(result.metres for result in results):.3f}',
        again + (' (may)' if KINDS[name].lets_go else ''),
        results[0].line,
        'yes' if all(result.is_well(KINDS[name]) for result in results) else 'NO',
    )


def _shown(rows: Iterable[tuple[str, ...]], total: int) -> Iterable[tuple[str, ...]]:
    """Yield rows; each is printed at once, in case the benchmark is ended."""
    for line in tqdm(rows, total=total, disable=None, leave=False):
        tqdm.write(' | '.join(line), file=sys.stderr)
        yield line


def main() -> int:
    """Print the table; returns 1 if any fault is not well."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--repeat', type=int, default=1)
    parser.add_argument('--jobs', type=int, default=1, help='faults at a time')
    parser.add_argument('--only', action='append', choices=list(KINDS))
    args = parsed(parser, repeat=1, only=['robot blocked'])
    print(f'{platform.platform()}, {os.cpu_count()} cores, Python {platform.python_version()}')
    names = args.only or list(KINDS)
    print(f'two robots at 0.21 m/s, {len(names)} faults, worst of {args.repeat} runs of each')
    with ThreadPool(args.jobs) as pool:
        rows = list(_shown(pool.imap(partial(row, args.repeat), names), len(names)))
    columns = ('fault', 'at rest after (s)', 'rolled (m)', 'moves off again', 'reported', 'well')
    print(tabulate(rows, columns, tablefmt='github', disable_numparse=True))
    load = os.getloadavg()[0]
    print(f'bounds: {MOST_S} s, {MOST_M} m; load at the end {load:.1f}')
    return int(any(line[-1] != 'yes' for line in rows))


if __name__ == '__main__':
    sys.exit(main())
