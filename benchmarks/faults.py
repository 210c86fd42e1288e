"""Injects every kind of fault into a rehearsed experiment; prints how robots stop, and stay.

Run in the environment that setcmas is installed in, on a quiet machine, as root for the network:

    python benchmarks/faults.py [--repeat 3] [--only 'mocap nan']
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import sys
import traceback
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / 'tests'))
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

from fault_kinds import arena, guards, mocap, network, people, processes, rogues, scripts
from fault_kinds.kind import Kind
from fault_places import rehearsal
from network_namespaces import NoNetworkError, in_a_process
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
STATUS = re.compile('RUNNING|STARTING|STOPPED|PAUSED|EMERGENCY')

KINDS: dict[str, Kind] = {
    name: kind
    for room in (processes, scripts, mocap, arena, guards, people, rogues, network)
    for name, kind in room.KINDS.items()
}


@dataclass(frozen=True)
class Result:
    """What became of a fault: the worst of its robots, and what was told."""

    seconds: float
    metres: float
    again: bool
    line: str

    def is_well(self, kind: Kind) -> bool:
        stays = kind.lets_go or not self.again
        told = bool(self.line) or not kind.line
        soon = self.seconds <= MOST_S or not kind.moving
        return soon and self.metres < MOST_M and stays and told


def measured(name: str) -> Result:
    """Bring a fault about, in a domain of its own."""
    kind = KINDS[name]
    with reserved_domain() as domain, rehearsal(kind, domain) as running:
        if kind.moving:
            running.let_go()
            running.peer.spin(1.0)
        told = len(running.output())
        fault = kind.inject(running)
        stops = kind.stops(running, fault)
        running.peer.spin(LASTS_S)
        kind.undo(running)
        running.peer.spin(WATCHED_S)
        rest = fault + max(stop.seconds for stop in stops) + STANDS_S
        return Result(
            max(stop.seconds for stop in stops),
            max(stop.metres for stop in stops),
            _set_off_again(running, rest),
            _line(running.output()[told:], kind),
        )


def _set_off_again(running: Rehearsal, rest: float) -> bool:
    return any(
        truth.stamp > rest and truth.rolls > CREEPS_M_S
        for samples in running.truth.values()
        for truth in samples
    )


def _line(output: str, kind: Kind) -> str:
    """Return the first line that tells the fault, apart from those of the state of all robots."""
    told = [line for line in output.splitlines() if not STATUS.match(line)]
    found = [line for line in told if kind.line and re.search(kind.line, line)]
    if kind.line and not found:
        print(f"no line has '{kind.line}':", *told, sep='\n  ')
    return found[0].strip() if found else ''


def row(name: str, repeat: int) -> tuple[str, ...]:
    """Measure a fault several times; returns a line of the table with the worst values."""
    try:
        results = [in_a_process(measured, name) for _ in range(repeat)]
    except (AssertionError, NoNetworkError):
        traceback.print_exc()
        return name, 'not measured', '', '', '', 'NO'
    again = sum(result.again for result in results)
    return (
        name,
        f'{max(result.seconds for result in results):.2f}',
        f'{max(result.metres for result in results):.3f}',
        f'{again} of {repeat}' + (' (may)' if KINDS[name].lets_go else ''),
        results[0].line,
        'yes' if all(result.is_well(KINDS[name]) for result in results) else 'NO',
    )


def main() -> int:
    """Print the table; returns 1 if any fault is not well."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--repeat', type=int, default=3)
    parser.add_argument('--only', action='append', choices=list(KINDS))
    args = parser.parse_args()
    print(f'{platform.platform()}, {os.cpu_count()} cores, Python {platform.python_version()}')
    print(f'two robots at 0.21 m/s, worst of {args.repeat} runs of each fault')
    rows = [row(name, args.repeat) for name in tqdm(args.only or KINDS, disable=None, leave=False)]
    columns = ('fault', 'stands after (s)', 'rolled (m)', 'set off again', 'told', 'well')
    print(tabulate(rows, columns, tablefmt='github', disable_numparse=True))
    load = os.getloadavg()[0]
    print(f'bounds: {MOST_S} s, {MOST_M} m; load at the end {load:.1f}')
    return int(any(line[-1] != 'yes' for line in rows))


if __name__ == '__main__':
    sys.exit(main())
