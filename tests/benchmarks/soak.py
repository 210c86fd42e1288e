"""Fleet under resets, pauses, reloads, latecomers and kills for many minutes, with a verdict.

    python tests/benchmarks/soak.py --minutes 20 [--seed 0] [--output soak.png]

Robots 1 to 4, their controllers, and a recorder live all the time; the processes of robots 5 to 8
are killed and started again. Nothing of those that live may grow, and nothing may get lost.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import signal
import statistics
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

import rclpy
from processes import CTRL, NO_WINDOWS, SIMU, Process
from ros_domain import reserved_domain
from soak_picture import picture
from soak_watch import Holding, Observer, Stream, holding
from std_msgs.msg import Bool, Empty

from setcmas_simu.ros.dds_setup import dds_setup
from setcmas_simu.ros.process import FleetNode
from setcmas_tools.bags.reader import open_bag

NB_ROBOTS = 8
LIVING, MORTAL = '1-4', '5-8'
LIVING_PROCESSES = (f'simulator {LIVING}', f'controllers {LIVING}', 'recorder')
RECORDER = [sys.executable, '-m', 'setcmas_tools.recorder.main', '--output']
VIEW = [sys.executable, '-m', 'setcmas_tools.view.main']
LAW = """
import math
PHASE = {phase}
def control(robotNo, nbRobots, poses, t):
    return 0.3 * math.cos(0.3 * t + PHASE), 0.3 * math.sin(0.3 * t + PHASE)
"""
RECOVERY_S = 30.0
SILENCE_S = 2.0
SAME_T_S = 0.1
MEMORY_MB = 4.0  # by how much a process may differ from itself in the beginning
LATE_MS = 20.0  # by how much the 99th percentile of ages may


class Soak:
    """The fleet, what happens to it, and what was seen of it."""

    def __init__(self, folder: Path, node: FleetNode, seed: int) -> None:
        self._folder = folder
        self._law = folder / 'law.py'
        self._chance = random.Random(seed)
        self._observer = Observer(node, NB_ROBOTS)
        self._reset = node.create_publisher(Empty, '/reset', 10)
        self._pause = node.create_publisher(Bool, '/pause', 10)
        self.begin = time.monotonic()
        self._next_look = 0.0
        self._counted_until = 0.0
        self._nb_logs = 0
        self.processes: dict[str, Process] = {}
        self.holdings: dict[str, list[Holding]] = defaultdict(list)
        self.ages: list[tuple[float, float, float]] = []  # at, median, 99th percentile, in s
        self.events: list[tuple[float, str]] = []
        self.troubles: list[str] = []

    @property
    def now(self) -> float:
        """Time in s since the begin."""
        return time.monotonic() - self.begin

    def start_fleet(self) -> None:
        """Start everything, and wait until all robots are commanded."""
        self._write_law()
        self._start('recorder', *RECORDER, str(self._folder / 'bag'))
        for robots in (LIVING, MORTAL):
            self._simulate(robots)
            self._control(robots)
        self.wait_until_well('start')

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
        event = self._chance.choice(events)
        name = event.__name__.strip('_').replace('_', ' ')
        self.events.append((self.now, name))
        event()
        self.wait_until_well(name)
        self.watch(self._chance.uniform(0.5, 3.0))

    def watch(self, seconds: float) -> None:
        """Watch for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._look()

    def wait_until_well(self, after: str) -> None:
        """Watch until all robots are seen and commanded, and all controllers have one t."""
        end = time.monotonic() + RECOVERY_S
        while missing := self._missing():
            if time.monotonic() > end:
                self.troubles.append(f'{self.now:.0f} s: {missing} {RECOVERY_S:g} s after {after}')
                return
            self._look()

    def end(self) -> None:
        """End all processes; each must do so in an orderly way."""
        for name, process in self.processes.items():
            if status := process.end():
                self.troubles.append(f'{name} ended with status {status}: {process.output()}')

    def count_no_more(self) -> None:
        """Let messages from now on not count; the steps missed till now are told in 2 s."""
        self._counted_until = time.time()
        for stream in self._observer.odometry.values():
            stream.until = self._counted_until
        self.watch(5.0)

    def lost(self) -> dict[str, int]:
        """Return how many messages of each living robot are missing, but for missed steps.

        As seen, and as recorded.
        """
        told = re.findall(r'(\d+) steps? w', self.processes[f'simulator {LIVING}'].output())
        missed = sum(map(int, told))
        until = self._counted_until
        recorded = {f'/tb3_{robot}/odom': Stream(0.1, until) for robot in range(1, 5)}
        with open_bag(self._folder / 'bag') as bag:
            for topic, stamp, _ in bag.messages():
                if stream := recorded.get(topic.name):
                    stream.add(1e-9 * stamp)
        streams = recorded | {f'seen of {i}': self._observer.odometry[i] for i in range(1, 5)}
        lost = {name: stream.missing - missed for name, stream in streams.items()}
        # The first and the last may be late by half a period.
        return {name: count for name, count in lost.items() if count > 1}

    def _missing(self) -> str:
        observer = self._observer
        for what, streams in (('odometry', observer.odometry), ('commands', observer.commands)):
            silent = [robot for robot, stream in streams.items() if stream.silence > 1.0]
            if silent:
                return f'no {what} of robots {silent}'
        apart = observer.spread_of_t()
        return f't is {apart:.2f} s apart' if apart > SAME_T_S else ''

    def _look(self) -> None:
        time.sleep(0.02)
        self._observer.take()
        if self.now < self._next_look:
            return
        self._next_look = self.now + 1.0
        for name, process in self.processes.items():
            if process.popen.poll() is None:
                self.holdings[name].append(holding(process.pid, self.now))
        if len(ages := self._observer.ages()) > 1:
            cuts = statistics.quantiles(ages, n=100)
            self.ages.append((self.now, cuts[49], cuts[98]))
        for robot in range(1, 5):
            if self._observer.odometry[robot].count:
                self._notice_silence(robot)

    def _notice_silence(self, robot: int) -> None:
        for what, stream in (
            ('odometry', self._observer.odometry[robot]),
            ('commands', self._observer.commands[robot]),
        ):
            if SILENCE_S < stream.silence < SILENCE_S + 1.0:
                self.troubles.append(f'{self.now:.0f} s: no {what} of tb3_{robot}, which lives')

    def _start(self, name: str, *command: str) -> None:
        self._nb_logs += 1
        log = self._folder / f'{self._nb_logs}.txt'
        self.processes[name] = Process(command, log, self._folder, os.environ | NO_WINDOWS)

    def _simulate(self, robots: str) -> None:
        part = ['--nb-robots', str(NB_ROBOTS), '--robots', robots, '--cmd-timeout', '0.5']
        self._start(f'simulator {robots}', *SIMU, *part)

    def _control(self, robots: str) -> None:
        part = ['--nb-robots', str(NB_ROBOTS), '--robots', robots]
        self._start(f'controllers {robots}', *CTRL, '--algo', str(self._law), '--watch', *part)

    def _write_law(self) -> None:
        self._law.write_text(LAW.format(phase=self._chance.random()))

    def _reset_fleet(self) -> None:
        self._reset.publish(Empty())

    def _pause_fleet(self) -> None:
        self._pause.publish(Bool(data=True))
        self.watch(self._chance.uniform(0.2, 3.0))
        self._pause.publish(Bool(data=False))

    def _reload(self) -> None:
        self._write_law()
        self.watch(1.0)

    def _kill_simulator(self) -> None:
        self.processes[f'simulator {MORTAL}'].end(signal.SIGKILL)
        self.watch(self._chance.uniform(0.0, 8.0))
        self._simulate(MORTAL)
        self.watch(1.0)

    def _kill_controllers(self) -> None:
        self._end_mortal_controllers(signal.SIGKILL)

    def _end_controllers(self) -> None:
        self._end_mortal_controllers(signal.SIGINT)

    def _end_mortal_controllers(self, signum: int) -> None:
        self.processes[f'controllers {MORTAL}'].end(signum)
        self.watch(self._chance.uniform(0.0, 8.0))
        self._control(MORTAL)
        self.watch(1.0)

    def _record(self) -> None:
        bag = self._folder / f'late_{self._nb_logs}'
        self._come_and_go('late recorder', 'recording', *RECORDER, str(bag))
        with open_bag(bag) as opened:
            seen = Counter(topic.name for topic, _, _ in opened.messages())
        if unrecorded := [i for i in range(1, NB_ROBOTS + 1) if not seen[f'/tb3_{i}/odom']]:
            self.troubles.append(f'{self.now:.0f} s: a bag has no odometry of {unrecorded}')

    def _view(self) -> None:
        self._come_and_go('view', 'browser view', *VIEW)

    def _come_and_go(self, name: str, word: str, *command: str) -> None:
        self._start(name, *command)
        end = time.monotonic() + RECOVERY_S
        while word not in self.processes[name].output() and time.monotonic() < end:
            self._look()
        self.watch(4.0)
        process = self.processes.pop(name)
        if status := process.end():
            self.troubles.append(f'{name} ended with status {status}: {process.output()}')


def growths(soak: Soak) -> list[str]:
    """Return what has grown: of processes that live all the time, and of the messages' ages."""
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
    if after > before + LATE_MS:
        found.append(f'ages of messages: {before:.1f} ms -> {after:.1f} ms')
    return found


def ends(samples: list) -> tuple[list, list]:
    """Return the second and the last fifth: in the first one a process fills its caches."""
    fifth = max(1, len(samples) // 5)
    return samples[fifth : 2 * fifth], samples[-fifth:]


def main() -> int:
    """Soak, draw and judge; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--minutes', type=float, default=20.0)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--output', type=Path, default=Path('soak.png'))
    args = parser.parse_args()
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
            *growths(soak),
            *(f'{n}: {c} lost' for n, c in soak.lost().items()),
        ]
    print('\n'.join(['wrong:', *wrong] if wrong else ['nothing grew, nothing was lost']))
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main())
