"""Fleet under resets, pauses, reloads, latecomers and kills for many minutes, with a verdict.

    python benchmarks/soak.py --minutes 20 [--seed 0] [--output soak.png]

Robots 1 to 4, their controllers, and a recorder live all the time; the processes of robots 5 to 8
are killed and started again. Nothing of those that live may grow, and nothing may get lost.
"""

from __future__ import annotations

import argparse
import math
import os
import signal
import statistics
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / 'tests'))
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

import rclpy
from quick_option import parsed
from ros_domain import reserved_domain
from soak_fleet import LIVING_PROCESSES, MORTAL, NB_ROBOTS, RECORDER, RECOVERY_S, SoakedFleet
from soak_picture import picture
from std_msgs.msg import Bool, Empty

from setcmas_simu.ros.dds_setup import dds_setup
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_tools.bags.bag_reader import open_bag

VIEW = [sys.executable, '-m', 'setcmas_tools.page.live_page']
MEMORY_MB = 4.0  # by how much a process may differ from itself in the beginning


class Soak(SoakedFleet):
    """What happens to the fleet."""

    def happen(self) -> None:
        """Let something happen, and wait until the fleet is well again."""
        events: list[Callable[[], None]] = [
            self._reset_fleet,
            self._pause_fleet,
            self._reload,
            self._kill_simulator,
            self._kill_controllers,
            self._end_controllers,
            self._record,
            self._view,
        ]
        event = self.chance.choice(events)
        name = event.__name__.strip('_').replace('_', ' ')
        self.events.append((self.now, name))
        event()
        self.wait_until_well(name)
        self.watch(self.chance.uniform(0.5, 3.0))

    def _reset_fleet(self) -> None:
        self.reset_publisher.publish(Empty())

    def _pause_fleet(self) -> None:
        self.pause_publisher.publish(Bool(data=True))
        self.watch(self.chance.uniform(0.2, 3.0))
        self.pause_publisher.publish(Bool(data=False))

    def _reload(self) -> None:
        self.write_law()
        self.watch(1.0)

    def _kill_simulator(self) -> None:
        self.processes[f'simulator {MORTAL}'].end(signal.SIGKILL)
        self.watch(self.chance.uniform(0.0, 8.0))
        self.simulate(MORTAL)
        self.watch(1.0)

    def _kill_controllers(self) -> None:
        self._end_mortal_controllers(signal.SIGKILL)

    def _end_controllers(self) -> None:
        self._end_mortal_controllers(signal.SIGINT)

    def _end_mortal_controllers(self, signum: int) -> None:
        self.processes[f'controllers {MORTAL}'].end(signum)
        self.watch(self.chance.uniform(0.0, 8.0))
        self.control(MORTAL)
        self.watch(1.0)

    def _record(self) -> None:
        bag = self.folder / f'late_{self.nb_logs}'
        self._come_and_go('late recorder', 'recording', *RECORDER, str(bag))
        with open_bag(bag) as opened:
            seen = Counter(topic.name for topic, _, _ in opened.messages())
        if unrecorded := [i for i in range(1, NB_ROBOTS + 1) if not seen[f'/tb3_{i}/odom']]:
            self.troubles.append(f'{self.now:.0f} s: a bag has no odometry of {unrecorded}')

    def _view(self) -> None:
        self._come_and_go('view', 'browser view', *VIEW)

    def _come_and_go(self, name: str, word: str, *command: str) -> None:
        self.start(name, *command)
        end = time.monotonic() + RECOVERY_S
        while word not in self.processes[name].output() and time.monotonic() < end:
            self.look()
        self.watch(4.0)
        process = self.processes.pop(name)
        if status := process.end():
            self.troubles.append(f'{name} ended with status {status}: {process.output()}')


def growths(soak: Soak, late_ms: float) -> list[str]:
    """Return what has grown: in processes that live all the time, and ages of messages.

    Args:
        soak: What was watched.
        late_ms: By how many ms the 99th percentile of ages may grow.
    """
    found = []
    for name in LIVING_PROCESSES:
        early, late = ends(soak.holdings[name])
        for what in ('memory', 'threads', 'descriptors', 'sockets'):
            before, after = (
                statistics.median(getattr(one, what) for one in part) for part in (early, late)
            )
            print(f'{name:18} {what:12} {before:8.1f} -> {after:8.1f}')
            if after > before + (MEMORY_MB if what == 'memory' else 0):
                found.append(f'{what} of {name}: {before:.1f} -> {after:.1f}')
    before, after = (
        1e3 * statistics.median(p99 for _, _, p99 in part) for part in ends(soak.ages)
    )
    print(f'{"messages":18} {"age (ms)":12} {before:8.1f} -> {after:8.1f}   (99th percentile)')
    if after > before + late_ms:
        found.append(f'ages of messages: {before:.1f} ms -> {after:.1f} ms')
    return found


def ends(samples: list) -> tuple[list, list]:
    """Return the second and the last fifth: in the first one a process fills its caches."""
    fifth = max(1, len(samples) // 5)
    return samples[fifth : 2 * fifth], samples[-fifth:]


def main() -> int:
    """Soak, draw and judge; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--minutes', type=float, default=20.0)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument(
        '--late', type=float, default=20.0,
        help='by how many ms the 99th percentile of ages may grow',
    )  # fmt: skip
    parser.add_argument('--output', type=Path, default=Path('soak.png'))
    args = parsed(parser, minutes=0.2, late=math.inf)
    with reserved_domain() as domain, tempfile.TemporaryDirectory() as folder:
        os.environ['ROS_DOMAIN_ID'] = str(domain)
        with dds_setup():
            rclpy.init()
        soak = Soak(Path(folder), FleetNode('soak'), args.seed)
        try:
            soak.start_fleet()
            soak.watch(5.0)
            while soak.now < 60 * args.minutes:
                soak.happen()
            soak.count_no_more()
            soak.end()
        finally:
            for process in soak.processes.values():
                process.kill_group()
            rclpy.shutdown()
        picture(soak.holdings, soak.ages, soak.events, LIVING_PROCESSES, args.output)
        print(f'{soak.now / 60:.1f} minutes:', dict(Counter(name for _, name in soak.events)))
        wrong = [
            *soak.troubles,
            *growths(soak, args.late),
            *(f'{n}: {c} lost' for n, c in soak.lost().items()),
        ]
    print('\n'.join(['wrong:', *wrong] if wrong else ['nothing grew, nothing was lost']))
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main())
