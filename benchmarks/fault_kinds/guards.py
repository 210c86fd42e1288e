"""Guards and robots that fail, or that are not what they seem."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rehearsal import BRIDGES, Rehearsal
from std_msgs.msg import Bool

from fault_kinds.kind import Kind, falls_silent, sends
from setcmas_simu.ros import qos

LIDAR_LAB = str(Path(__file__).parents[2] / 'tests' / 'data' / 'lidar_lab.yaml')


def _release(r: Rehearsal) -> None:
    r.press('R')
    r.peer.spin(1.2)  # a key that is held down comes sooner
    r.press('R')


def _false_release(r: Rehearsal) -> float:
    """Hold a stop, and have another node say that it is released."""
    stop = r.press('\x1b')
    r.peer.spin(2.0)
    sends(r, '/emergency_stopped', Bool(), qos=qos.LATCHED)
    sends(r, '/paused', Bool(), qos=qos.STATE)
    return stop


def _latched(r: Rehearsal) -> float:
    """Let motion capture lose the other robot; return when that pauses both."""
    r.fault('dropout 2 2')
    r.peer.wait_for(lambda: 'paused: robot 2' in r.output())
    return time.time()


def _deaf(
    stop: Callable[[Rehearsal], float], line: str = 'does not obey zero', **how: Any
) -> Kind:
    """Return a stop of a robot whose base keeps its last command."""

    def inject(r: Rehearsal) -> float:
        r.fault('deaf 1 60')
        r.peer.spin(0.5)
        return stop(r)

    return Kind(inject, line, **how)


def _space_bar_at_a_crawl(r: Rehearsal) -> float:
    r.peer.wait_for(lambda: 'controlling robot' in r.output())
    r.press_until(lambda: r.truth[1][-1].rolls > 0.0)
    r.fault('deaf 1 60')
    r.peer.spin(0.5)
    return r.press(' ')


KINDS = {
    'deaf base, space bar': _deaf(lambda r: r.press(' ')),
    'deaf base, Esc': _deaf(lambda r: r.press('\x1b'), 'STOP by'),
    'deaf base, latched stop': _deaf(_latched),
    'deaf base, bridge killed (-9)': _deaf(lambda r: r.kill(BRIDGES), 'bridge process has died'),
    'deaf base that creeps, space bar': Kind(
        _space_bar_at_a_crawl, 'does not obey zero', options=('--vnom', '0.02'), moving=False
    ),
    'guard hung': Kind(lambda r: r.fault('unguarded 1 4'), 'cmd_vel_guard is silent'),
    'a person steps in front of its lidar': Kind(
        lambda r: r.fault('person 1 2'), 'its lidar sees something', options=('--lab', LIDAR_LAB)
    ),
    'robot off and on': Kind(lambda r: r.fault('off 1 4'), 'paused: robot'),
    'another node reports as the guard': Kind(
        lambda r: sends(r, '/tb3_1/guard_state', DiagnosticStatus()),
        'report as its guard|report is invalid',
        falls_silent,
    ),
    'Esc, then released by the operator': Kind(lambda r: r.press('\x1b'), 'STOP by', _release),
    'Esc, then released by another node': Kind(_false_release, 'STOP by', falls_silent),
}
