"""Injects every fault into a rehearsed experiment; prints how soon and how far on robots stop.

Run in the environment that setcmas is installed in, on a quiet machine, as root for the network:

    python tests/benchmarks/faults.py [--repeat 3] [--only 'mocap nan']
"""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import platform
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

from network_namespaces import UDP_ONLY, Network, NoNetworkError, in_a_process
from rehearsal import BRIDGES, CTRL, PAUSE, POSES, Rehearsal, Stop, Truth
from ros_domain import reserved_domain
from ros_peer import Peer
from sensor_msgs.msg import Joy
from tabulate import tabulate
from tqdm import tqdm

from setcmas_expe.lab.file import DEFAULT_FILE, load_lab

MOST_S, MOST_M = 0.7, 0.16
ARENA = load_lab(DEFAULT_FILE, 2).arena
SEPARATION = load_lab(DEFAULT_FILE, 2).min_separation
EMULATED_LAB = [sys.executable, '-m', 'setcmas_expe.emulation.lab']

Outcome = list[Stop]


def kill(module: str) -> Callable[[Rehearsal], Outcome]:
    return lambda r: both(r, r.kill(module))


def both(r: Rehearsal, fault: float) -> Outcome:
    return [r.wait_for_stop(fault, robot) for robot in r.truth]


def suspend(module: str) -> Callable[[Rehearsal], Outcome]:
    return lambda r: both(r, r.kill(module, signal.SIGSTOP))


def mocap(kind: str) -> Callable[[Rehearsal], Outcome]:
    def run(r: Rehearsal) -> Outcome:
        fault = r.fault(f'{kind} 1 2')
        return both(r, fault) if kind == 'swap' else [r.wait_for_stop(fault)]

    return run


def push(r: Rehearsal) -> Outcome:
    """Count from where the robot leaves the arena: only rolling on outwards is forbidden."""
    r.fault('push 1 6')

    def outside(truth: Truth) -> bool:
        return ARENA.distance(truth.x, truth.y) > 0

    r.peer.wait_for(lambda: outside(r.truth[1][-1]))
    left = next(truth for truth in reversed(r.truth[1]) if not outside(truth))

    def outwards(truth: Truth) -> float:
        normals = ARENA.outward_normals(truth.x, truth.y)
        return max((truth.rolls_towards(math.atan2(y, x)) for x, y in normals), default=0.0)

    return [r.wait_for_stop(left.stamp, rolls=outwards)]


def collide(r: Rehearsal) -> Outcome:
    """Count from where robots are too near: only rolling on towards each other is forbidden."""
    r.set_mode('collide')
    first, second = r.truth[1], r.truth[2]

    def gap() -> float:
        return math.hypot(first[-1].x - second[-1].x, first[-1].y - second[-1].y)

    r.peer.wait_for(lambda: gap() < SEPARATION, 60)
    near = first[-1].stamp
    stops = []
    for robot, other in ((1, second), (2, first)):
        place = other[-1]

        def towards(truth: Truth, place: Truth = place) -> float:
            return truth.rolls_towards(math.atan2(place.y - truth.y, place.x - truth.x))

        stops.append(r.wait_for_stop(near, robot, towards))
    return stops


def joystick_gone(r: Rehearsal) -> Outcome:
    joystick = r.peer.node.create_publisher(Joy, '/joy', 10)
    end = time.monotonic() + 1.5
    while time.monotonic() < end:
        joystick.publish(Joy(buttons=[0] * 11, axes=[0.0] * 8))
        gone = time.time()
        r.peer.spin(0.05)
    return both(r, gone)


SCENARIOS: dict[str, Callable[[Rehearsal], Outcome]] = {
    'controller killed (-9)': kill(CTRL),
    'bridge killed (-9)': kill(BRIDGES),
    'pause node killed (-9)': kill(PAUSE),
    'controller hung': suspend(CTRL),
    'bridge hung': suspend(BRIDGES),
    'pause node hung': suspend(PAUSE),
    'mocap dropout': mocap('dropout'),
    'mocap zeros': mocap('zero'),
    'mocap nan': mocap('nan'),
    'mocap frozen': mocap('frozen'),
    'mocap jump': mocap('jump'),
    'mocap swapped names': mocap('swap'),
    'mocap late': mocap('late'),
    'joystick gone': joystick_gone,
    'script stuck': lambda r: both(r, r.set_mode('stuck')),
    'script NaN': lambda r: both(r, r.set_mode('nan')),
    'pushed out of the arena': push,
    'collision course': collide,
    'Ctrl-C': lambda r: both(r, r.press_ctrl_c()),
    'SIGTERM': lambda r: both(r, r.signal(signal.SIGTERM)),
    'terminal closed': lambda r: both(r, r.close_terminal()),
}


@contextmanager
def rehearsal(domain: int) -> Iterator[Rehearsal]:
    os.environ['ROS_DOMAIN_ID'] = str(domain)
    with (
        tempfile.TemporaryDirectory() as folder,
        Peer(domain) as peer,
        Rehearsal(peer, Path(folder)) as running,
    ):
        running.let_go()
        peer.spin(1.0)
        yield running


@contextmanager
def emulated_lab(folder: Path) -> Iterator[Path]:
    """Run robots and motion capture on their own; hands out the file of what they say."""
    log = folder / 'lab.txt'
    command = [*EMULATED_LAB, '--nb-robots', '2', *POSES]
    with log.open('wb') as file, subprocess.Popen(command, stdout=file, stderr=file) as lab:
        try:
            yield log
        finally:
            lab.terminate()


def in_a_lab(scenario: Callable[[Rehearsal], Outcome]) -> Callable[[int], tuple[Outcome, bool]]:
    """Run robots and motion capture on their own, over UDP as on a network."""

    def run(domain: int) -> tuple[Outcome, bool]:
        os.environ.update(
            UDP_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE='SUBNET', ROS_DOMAIN_ID=str(domain)
        )
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            with (
                emulated_lab(folder) as log,
                Peer(domain) as peer,
                Rehearsal(peer, folder, lab=()) as running,
            ):
                running.let_go()
                peer.spin(1.0)
                return scenario(running), spoke_up(log)

    return run


def cut_network(domain: int) -> tuple[Outcome, bool]:
    """Run robots and motion capture on one machine, the experiment on another; pull its plug."""
    with tempfile.TemporaryDirectory() as name, Network('robots', 'laptop') as network:
        folder = Path(name)
        peers = {'ROS_STATIC_PEERS': ';'.join(network.addresses.values())}
        os.environ.update(UDP_ONLY, ROS_DOMAIN_ID=str(domain), **peers)
        before = network.command('laptop', [])
        try:
            with contextlib.ExitStack() as stack:
                with network.on('robots'):
                    log = stack.enter_context(emulated_lab(folder))
                    peer = stack.enter_context(Peer(domain))
                rehearsal = Rehearsal(peer, folder, before=before, lab=())
                running = stack.enter_context(rehearsal)
                running.let_go()
                peer.spin(1.0)
                now = time.time()
                network.cut('laptop')
                return both(running, now), spoke_up(log)
        finally:
            for variable in (*UDP_ONLY, *peers):
                os.environ.pop(variable)


def spoke_up(log: Path) -> bool:
    return 'commands have ended' in log.read_text()


def measured(name: str) -> tuple[Outcome, bool]:
    """Return how the robots stopped, and whether a cmd_vel_guard had to speak up."""
    with reserved_domain() as domain:
        if name in APART:
            return APART[name](domain)
        with rehearsal(domain) as running:
            return SCENARIOS[name](running), spoke_up(running.log)


def row(name: str, repeat: int) -> tuple[str, str, str, str, str]:
    """Measure a fault several times; returns a line of the table with the worst values."""
    stops: list[Stop] = []
    guarded = 0
    for _ in range(repeat):
        try:
            outcome, guard = in_a_process(measured, name)
        except (AssertionError, NoNetworkError):
            traceback.print_exc()
            return name, 'not measured', '', '', 'NO'
        stops += outcome
        guarded += guard
    seconds, metres = max(s.seconds for s in stops), max(s.metres for s in stops)
    well = 'yes' if seconds <= MOST_S and metres < MOST_M else 'NO'
    return name, f'{seconds:.2f}', f'{metres:.3f}', f'{guarded} of {repeat}', well


APART = {
    'setcmas expe hung': in_a_lab(lambda r: both(r, r.signal(signal.SIGSTOP))),
    'setcmas expe killed (-9)': in_a_lab(lambda r: both(r, r.signal(signal.SIGKILL))),
    "laptop's network cut": cut_network,
}
"""Faults under which robots and motion capture must not be children of setcmas expe."""


def main() -> int:
    """Print the table; returns 1 if a robot stopped too late."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--repeat', type=int, default=3)
    parser.add_argument('--only', action='append', choices=[*SCENARIOS, *APART])
    args = parser.parse_args()
    names = args.only or [*SCENARIOS, *APART]
    print(f'{platform.platform()}, {os.cpu_count()} cores, Python {platform.python_version()}')
    print(f'two robots at 0.21 m/s, worst of {args.repeat} runs of each fault')
    rows = []
    for name in tqdm(names, disable=None, leave=False):
        rows.append(row(name, args.repeat))
    columns = ('fault', 'stands after (s)', 'rolled (m)', 'guard acted', 'within bounds')
    print(tabulate(rows, columns, tablefmt='github', disable_numparse=True))
    load = os.getloadavg()[0]
    print(f'bounds: {MOST_S} s, {MOST_M} m; load at the end {load:.1f}')
    return int(any(line[-1] != 'yes' for line in rows))


if __name__ == '__main__':
    sys.exit(main())
