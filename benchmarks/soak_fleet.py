"""Fleet that is soaked: its processes, and what is seen of them."""

from __future__ import annotations

import os
import random
import re
import statistics
import sys
import time
from collections import defaultdict
from pathlib import Path

from processes import CTRL, NO_WINDOWS, SIMU, Process
from soak_watch import Holding, Observer, Stream, holding
from std_msgs.msg import Bool, Empty

from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_tools.bags.bag_reader import open_bag

NB_ROBOTS = 8
LIVING, MORTAL = '1-4', '5-8'
LIVING_PROCESSES = (f'simulator {LIVING}', f'controllers {LIVING}', 'recorder')
RECORDER = [sys.executable, '-m', 'setcmas_tools.bags.recorder', '--output']
LAW = """
import math
PHASE = {phase}
def control(robotNo, nbRobots, poses, t):
    return 0.3 * math.cos(0.3 * t + PHASE), 0.3 * math.sin(0.3 * t + PHASE)
"""
RECOVERY_S = 30.0
SILENCE_S = 2.0
SAME_T_S = 0.1


class SoakedFleet:
    """Processes of a fleet, and what was seen of them."""

    def __init__(self, folder: Path, node: FleetNode, seed: int) -> None:
        self.folder = folder
        self.law = folder / 'law.py'
        self.chance = random.Random(seed)
        self.observer = Observer(node, NB_ROBOTS)
        self.reset_publisher = node.create_publisher(Empty, '/reset', 10)
        self.pause_publisher = node.create_publisher(Bool, '/pause', 10)
        self.begin = time.monotonic()
        self._next_look = 0.0
        self._counted_until = 0.0
        self.nb_logs = 0
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
        self.write_law()
        self.start('recorder', *RECORDER, str(self.folder / 'bag'))
        for robots in (LIVING, MORTAL):
            self.simulate(robots)
            self.control(robots)
        self.wait_until_well('start')

    def watch(self, seconds: float) -> None:
        """Watch for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.look()

    def wait_until_well(self, after: str) -> None:
        """Watch until all robots are seen and commanded, and all controllers have one t."""
        end = time.monotonic() + RECOVERY_S
        while missing := self._missing():
            if time.monotonic() > end:
                self.troubles.append(f'{self.now:.0f} s: {missing} {RECOVERY_S:g} s after {after}')
                return
            self.look()

    def end(self) -> None:
        """End all processes; each must do so in an orderly way."""
        for name, process in self.processes.items():
            if status := process.end():
                self.troubles.append(f'{name} ended with status {status}: {process.output()}')

    def count_no_more(self) -> None:
        """Let messages from now on not count; the steps missed till now are told in 2 s."""
        self._counted_until = time.time()
        for stream in self.observer.odometry.values():
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
        with open_bag(self.folder / 'bag') as bag:
            for topic, stamp, _ in bag.messages():
                if stream := recorded.get(topic.name):
                    stream.add(1e-9 * stamp)
        streams = recorded | {f'seen of {i}': self.observer.odometry[i] for i in range(1, 5)}
        lost = {name: stream.missing - missed for name, stream in streams.items()}
        # The first and the last may be late by half a period.
        return {name: count for name, count in lost.items() if count > 1}

    def _missing(self) -> str:
        observer = self.observer
        for what, streams in (('odometry', observer.odometry), ('commands', observer.commands)):
            silent = [robot for robot, stream in streams.items() if stream.silence > 1.0]
            if silent:
                return f'no {what} of robots {silent}'
        apart = observer.spread_of_t()
        return f't is {apart:.2f} s apart' if apart > SAME_T_S else ''

    def look(self) -> None:
        time.sleep(0.02)
        self.observer.take()
        if self.now < self._next_look:
            return
        self._next_look = self.now + 1.0
        for name, process in self.processes.items():
            if process.popen.poll() is None:
                self.holdings[name].append(holding(process.pid, self.now))
        if len(ages := self.observer.ages()) > 1:
            cuts = statistics.quantiles(ages, n=100)
            self.ages.append((self.now, cuts[49], cuts[98]))
        for robot in range(1, 5):
            if self.observer.odometry[robot].count:
                self._notice_silence(robot)

    def _notice_silence(self, robot: int) -> None:
        for what, stream in (
            ('odometry', self.observer.odometry[robot]),
            ('commands', self.observer.commands[robot]),
        ):
            if SILENCE_S < stream.silence < SILENCE_S + 1.0:
                self.troubles.append(f'{self.now:.0f} s: no {what} of tb3_{robot}, which lives')

    def start(self, name: str, *command: str) -> None:
        self.nb_logs += 1
        log = self.folder / f'{self.nb_logs}.txt'
        self.processes[name] = Process(command, log, self.folder, os.environ | NO_WINDOWS)

    def simulate(self, robots: str) -> None:
        part = ['--nb-robots', str(NB_ROBOTS), '--robots', robots, '--cmd-timeout', '0.5']
        self.start(f'simulator {robots}', *SIMU, *part)

    def control(self, robots: str) -> None:
        part = ['--nb-robots', str(NB_ROBOTS), '--robots', robots]
        self.start(f'controllers {robots}', *CTRL, '--algo', str(self.law), '--watch', *part)

    def write_law(self) -> None:
        self.law.write_text(LAW.format(phase=self.chance.random()))
