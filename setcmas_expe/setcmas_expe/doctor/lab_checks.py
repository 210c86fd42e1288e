"""Checks of a lab: the rate of poses, each robot, and what other presets would receive."""

from __future__ import annotations

import itertools
import math
import re
import statistics
from collections.abc import Iterable
from dataclasses import dataclass

from setcmas_expe.doctor.findings import NOTE, PROBLEM, Finding
from setcmas_expe.guard.guard_watch import GuardReport
from setcmas_expe.lab.lab import LOW_PERCENT, Lab, LabRobot
from setcmas_expe.mocap.pose_track import SLOWEST_HZ
from setcmas_expe.mocap.sample import Pose
from setcmas_expe.mocap.sources import MOCAP_SOURCES, NAME, MocapSource
from setcmas_simu.fleet.topics import CMD_VEL, CMD_VEL_GUARDED, CMD_VEL_TYPES, robot_name

_PLAUSIBLE_AGE_S = (-0.005, 2.0)  # outside, the clocks of the two machines differ


@dataclass(frozen=True)
class ArrivalStatistics:
    """The regularity of one topic.

    Attributes:
        rate: Messages per second.
        jitter: Standard deviation of the gaps between arrivals, in s.
        largest_gap: In s, including the time before the first and after the last message.
        age: Median age at arrival by the message's stamp, in s; None where the clocks of sender
            and receiver differ, or stamps are not set.
    """

    rate: float
    jitter: float
    largest_gap: float
    age: float | None


def arrival_statistics(
    arrivals: list[float], stamps: list[float], begin: float, end: float
) -> ArrivalStatistics:
    """Return the regularity of messages over a while.

    Args:
        arrivals: Times of arrival in s.
        stamps: Their stamps in s, on a clock that should agree; 0 if not set.
        begin: Start of the measurement in s.
        end: End of the measurement in s.
    """
    times = [begin, *arrivals, end]
    largest = max(later - earlier for earlier, later in itertools.pairwise(times))
    gaps = [later - earlier for earlier, later in itertools.pairwise(arrivals)]
    rate = len(gaps) / sum(gaps) if gaps and sum(gaps) > 0 else 0.0
    jitter = statistics.pstdev(gaps) if gaps else 0.0
    ages = [arrival - stamp for arrival, stamp in zip(arrivals, stamps, strict=True) if stamp]
    age = statistics.median(ages) if ages else None
    if age is not None and not _PLAUSIBLE_AGE_S[0] <= age <= _PLAUSIBLE_AGE_S[1]:
        age = None
    return ArrivalStatistics(rate, jitter, largest, age)


Graph = Iterable[tuple[str, list[str]]]


def other_presets(graph: Graph, preset: str) -> list[Finding]:
    """Return the other presets that fit existing topics, with their bodies.

    Args:
        graph: Each topic with its types.
        preset: The preset of the lab file.
    """
    graph = list(graph)
    listening: dict[str, list[str]] = {}
    for name, source in MOCAP_SOURCES.usable(lambda _: None).items():
        if name != preset and (found := heard_by(source, graph)):
            listening.setdefault(found, []).append(name)
    return [
        Finding(
            NOTE,
            'motion capture',
            f'{" or ".join(names)} would receive {found}',
            'set mocap.preset in the lab file, or --mocap',
        )
        for found, names in listening.items()
    ]


def heard_by(source: MocapSource, graph: Graph) -> str:
    """Return what a source would receive, in words; empty if nothing."""
    topics = [topic for topic, types in graph if source.message_type in types]
    if not source.per_body:
        return f'{source.topic}, with all bodies' if source.topic in topics else ''
    first, *again = source.topic.split(NAME)
    body = '([A-Za-z][A-Za-z0-9_]*)'
    form = re.escape(first) + body + '\\1'.join(map(re.escape, again))
    found = (re.fullmatch(form, topic) for topic in topics)
    return ', '.join(sorted(match[1] for match in found if match))


_LOW_PERCENT = 30.0
_SLOW_ROUND_TRIP_S = 0.1

COLUMNS = (
    'robot',
    'mocap',
    'jitter',
    'gap',
    'age',
    'place',
    'cmd_vel',
    'guard',
    'battery',
    'ping',
)


@dataclass(frozen=True)
class RobotCheck:
    """Measurements of one robot.

    Attributes:
        robot: The robot.
        mocap: Regularity of its poses.
        pose: The last good pose (m, rad); None if there is none.
        fault: What is wrong with its poses; None if nothing.
        kinds: The message types of the listeners to its cmd_vel.
        rival: Who else may move it, or move in its place; empty if none.
        guard: Last report of its cmd_vel_guard; None if there is none.
        battery: Charge in percent; None if unknown.
        round_trip: Time of a service call in s; None without an answer.
    """

    robot: LabRobot
    mocap: ArrivalStatistics
    pose: Pose | None
    fault: str | None
    kinds: list[str]
    rival: str
    guard: GuardReport | None
    battery: float | None
    round_trip: float | None

    def row(self) -> list[str]:
        """Return the robot's line in the table of COLUMNS."""
        mocap = self.mocap
        pose = self.pose
        seen = mocap.rate > 0
        return [
            robot_name(self.robot.number),
            f'{mocap.rate:.0f} Hz' if seen else 'silent',
            _ms(mocap.jitter if seen else None),
            _ms(mocap.largest_gap if seen else None),
            _ms(mocap.age),
            f'{pose[0]:.2f}, {pose[1]:.2f}, {round(math.degrees(pose[2]))} deg' if pose else '-',
            ', '.join(dict.fromkeys(self.kinds)) or 'no node',
            self._guard_word(),
            '-' if self.battery is None else f'{self.battery:.0f} %',
            _ms(self.round_trip),
        ]

    def findings(self, lab: Lab, bodies: list[str]) -> list[Finding]:
        """Return all problems and remarks.

        Args:
            lab: The lab.
            bodies: Names of the bodies that motion capture sends.
        """
        return [
            *self._of_mocap(lab, bodies),
            *self._of_commands(lab),
            *self._of_guard(),
            *self._of_robot(),
        ]

    def _finding(self, level: str, part: str, found: str, advice: str) -> Finding:
        return Finding(level, f'{part} of {robot_name(self.robot.number)}', found, advice)

    def _of_mocap(self, lab: Lab, bodies: list[str]) -> list[Finding]:
        topic = lab.mocap.topic_of(self.robot)
        if not self.mocap.rate:
            seen = f'it sends {", ".join(bodies)}' if bodies else 'it sends no body'
            advice = (
                f'on {lab.mocap.source.topic} {seen}: is its driver running, the robot in view, '
                'and are preset and mocap_name in the lab file right?'
            )
            return [self._finding(PROBLEM, 'mocap', f'nothing on {topic}', advice)]
        findings = []
        if self.fault:
            advice = 'look at the body in the motion capture system'
            findings.append(self._finding(PROBLEM, 'mocap', self.fault, advice))
        elif self.pose and lab.arena.distance(*self.pose[:2]) > 0:
            advice = 'put it inside, or widen the arena in the lab file'
            findings.append(self._finding(PROBLEM, 'place', 'outside the arena', advice))
        if self.mocap.largest_gap > lab.timeouts.pose_s:
            found = f'silent for {self.mocap.largest_gap:.1f} s'
            advice = 'the robot would stop: keep it in view, and check the network'
            findings.append(self._finding(PROBLEM, 'mocap', found, advice))
        elif self.mocap.rate < SLOWEST_HZ:
            advice = f'let motion capture send at {SLOWEST_HZ:g} Hz at least, better 50'
            findings.append(self._finding(NOTE, 'mocap', f'only {self.mocap.rate:.1f} Hz', advice))
        return findings

    def _of_commands(self, lab: Lab) -> list[Finding]:
        topic = self.robot.topic(CMD_VEL)
        if not self.kinds:
            advice = (
                'start the robot (ros2 launch turtlebot3_bringup robot.launch.py namespace:=... '
                'as in the lab file) with the same ROS_DOMAIN_ID; without multicast, name it as a '
                'static peer in the lab file'
            )
            found = f'nothing listens to {topic}'
            return [self._finding(PROBLEM, 'cmd_vel', found, advice)]
        findings = []
        strange = [kind for kind in self.kinds if kind not in CMD_VEL_TYPES]
        others = [kind for kind in self.kinds if kind != lab.cmd_vel_type]
        if strange:
            advice = 'it must be geometry_msgs TwistStamped or Twist'
            findings.append(self._finding(PROBLEM, 'cmd_vel', f'type {strange[0]}', advice))
        elif lab.cmd_vel_type in CMD_VEL_TYPES and others:
            found = f'it takes {others[0]}, the lab file says {lab.cmd_vel_type}'
            advice = 'set cmd_vel_type: auto in the lab file'
            findings.append(self._finding(PROBLEM, 'cmd_vel', found, advice))
        if self.rival:
            advice = (
                'stop the other commander, and give each robot its own namespace (a restarted '
                'robot appears twice for up to 20 s)'
            )
            findings.append(self._finding(PROBLEM, 'cmd_vel', self.rival, advice))
        return findings

    def _guard_word(self) -> str:
        if self.guard is None:
            return 'no'
        if self.guard.stops:
            return self.guard.state.value
        return 'yes' if self.guard.private else 'open'

    def _of_guard(self) -> list[Finding]:
        if self.guard is None:
            advice = (
                'a robot keeps its last velocity when this machine or the network dies; install '
                'cmd_vel_guard on the robots (docs/lab_setup.md), or start with --without-guard'
            )
            return [self._finding(PROBLEM, 'guard', 'not there', advice)]
        findings = []
        if self.guard.stops:
            advice = 'repair it; in an experiment, R twice releases an emergency stop'
            findings.append(self._finding(NOTE, 'guard', self.guard.reason, advice))
        if not self.guard.private:
            advice = (
                f'let its base listen to {CMD_VEL_GUARDED} alone (docs/lab_setup.md): now every '
                'machine on the network can move it'
            )
            found = f'the base listens to {CMD_VEL} directly'
            findings.append(self._finding(NOTE, 'guard', found, advice))
        return findings

    def _of_robot(self) -> list[Finding]:
        findings = []
        if self.battery is not None and self.battery < _LOW_PERCENT:
            level = PROBLEM if self.battery < LOW_PERCENT else NOTE
            found = f'{self.battery:.0f} %'
            findings.append(self._finding(level, 'battery', found, 'charge it'))
        if self.round_trip is not None and self.round_trip > _SLOW_ROUND_TRIP_S:
            found = f'{1e3 * self.round_trip:.0f} ms'
            advice = 'the network is slow: use 5 GHz, one access point near the robots'
            findings.append(self._finding(NOTE, 'round trip', found, advice))
        return findings


def _ms(seconds: float | None) -> str:
    return '-' if seconds is None else f'{1e3 * seconds:.1f} ms'
