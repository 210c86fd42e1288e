"""Runs over ROS and offline runs of the same law and options go the same way.

In lockstep they are the same to the last bit; with the wall's clock they are near each other.
"""

import contextlib
import math
import os
import subprocess
import sys

import numpy as np
import pytest
import yaml
from processes import SETCMAS, TIMEOUT_S, run_setcmas
from ros_domain import reserved_domain
from trajectory_comparison import compare

from setcmas_tools import simulate
from setcmas_tools.records.fleet_table import read_csv

pytest.importorskip('rclpy')

SWITCHING = """
segments:
  - {duration: 5, edges: [1 - 2, 3 - 4]}
  - {duration: 3.4, graph: directed_ring}
repeat: true
"""
RUNS = {
    'nav_wp': ('nav_wp', 2, {}),
    'traj_tracking': ('traj_tracking', 2, {}),
    'consensus': ('consensus', 8, {}),
    'leader_follower_formation': ('leader_follower_formation', 5, {}),
    'leader_follower_distance_formation': ('leader_follower_distance_formation', 4, {}),
    'a switching graph, late': ('consensus', 4, {'graph': 'switching.yaml', 'delay': 0.3}),
}
"""Law, number of robots, and further options of each run."""

LARGEST_RMS_M = 0.08  # per robot


def run_over_ros(names, duration, folder):
    """Let runs take place at the same time, each fleet in a domain of its own."""
    with contextlib.ExitStack() as stack:
        runs = []
        for name in names:
            algo, nb_robots, further = RUNS[name]
            domain = stack.enter_context(reserved_domain())
            options = ['--nb-robots', str(nb_robots), '--duration', str(duration)]
            options += [f'--{option}={value}' for option, value in further.items()]
            environment = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_DOMAIN_ID': domain}
            run = subprocess.Popen(
                [
                    *SETCMAS,
                    'run',
                    '--no-plots',
                    '--algo',
                    algo,
                    *options,
                    '-o',
                    name,
                    '--overwrite',
                ],
                cwd=folder,
                env={**os.environ, **{name: str(value) for name, value in environment.items()}},
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
            )
            stack.callback(run.kill)
            runs.append(run)
        for run in runs:
            output, _ = run.communicate(timeout=2 * TIMEOUT_S)
            print(output.decode())


def apart(name, duration, folder):
    """Return how far (m, RMS per robot) a run over ROS is from the offline run; inf: it failed."""
    record = yaml.safe_load((folder / name / 'run.yaml').read_text())
    if record['outcome']['state'] != 'complete':
        return math.inf
    algo, nb_robots, further = RUNS[name]
    offline = simulate(algo, nb_robots, duration, **further)
    table = read_csv(folder / name / 'csv' / 'fleet.csv')
    tracks = [table.of(robot) for robot in table.robots]
    assert len(tracks) == nb_robots
    over_ros = np.array(
        [np.interp(offline.t, track.t, axis) for track in tracks for axis in (track.x, track.y)]
    )
    ours = offline.poses[:, :2].transpose(2, 1, 0).reshape(2 * nb_robots, -1)
    return compare(offline.t, ours, offline.t, over_ros).rms / np.sqrt(nb_robots)


@pytest.mark.nightly
def test_ros_and_offline_runs_agree(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'switching.yaml').write_text(SWITCHING)
    duration = 20.0
    run_over_ros(RUNS, duration, tmp_path)
    rms = {name: apart(name, duration, tmp_path) for name in RUNS}
    # A machine that is busy with other tests delays commands, or starts; then one run at a time.
    for name in [name for name in RUNS if rms[name] >= LARGEST_RMS_M]:
        for _ in range(3):
            run_over_ros([name], duration, tmp_path)
            rms[name] = apart(name, duration, tmp_path)
            if rms[name] < LARGEST_RMS_M:
                break
    print(rms)
    assert max(rms.values()) < LARGEST_RMS_M, rms


NEAR = ['--random-poses=box=1.5x1.5,distance=0.45', '--filter=barrier', '--accel=1']
LOCKSTEP = {
    'late, event-triggered, filtered': (
        'consensus', 3, 4,
        ['--event-triggered', '--graph=ring', '--delay=0.25', '--loss=0.2', *NEAR],
    ),
}  # fmt: skip
NIGHTLY = {
    'traj_tracking': ('traj_tracking', 2, 4, []),
    'nav_wp': ('nav_wp', 4, 20, ['--limits=burger']),
    'leader_follower_formation': ('leader_follower_formation', 5, 20, []),
    'leader_follower_distance_formation': ('leader_follower_distance_formation', 4, 20, []),
    'rates': ('consensus', 4, 20, ['--rate=7', '--robot-rate=30']),
    'event-triggered': ('consensus', 8, 20, ['--event-triggered']),
    'range': ('consensus', 8, 20, ['--range=6', '--random-poses', '--seed=4']),
    'switching': ('consensus', 4, 10, ['--graph=switching.yaml', '--delay=0.3']),
    'blocked': ('consensus', 8, 20, ['--filter=barrier', '--deadlock=turn', '--limits=burger']),
    'car': ('consensus', 4, 10, ['--model=1:car,2:burger']),
}
BUSY = {
    'fifty on a ring': (
        'consensus', 50, 10, ['--graph=ring', '--loss=0.3', '--delay=0.1', '--noise=0.02']
    ),
}  # fmt: skip
"""Law, number of robots, duration in s, and further options of runs in lockstep."""


def lockstep_agrees(name, folder):
    """Run in lockstep and offline; every table that both have is the same to the last byte."""
    algo, nb_robots, duration, further = (LOCKSTEP | NIGHTLY | BUSY)[name]
    options = ['--algo', algo, '--nb-robots', str(nb_robots), '--duration', str(duration)]
    options += [*further, '--no-plots']
    (folder / 'switching.yaml').write_text(SWITCHING)
    ros = run_setcmas(
        'run', '--lockstep', *options, '-o', 'ros', cwd=folder, timeout=3 * TIMEOUT_S
    )
    assert ros.returncode == 0, ros.stdout + ros.stderr
    offline = run_setcmas('offline', *options, '-o', 'offline', cwd=folder)
    assert offline.returncode == 0, offline.stdout + offline.stderr
    tables = {path.name for path in (folder / 'offline' / 'csv').iterdir()}
    assert {'fleet.csv', 'commands.csv'} <= tables
    for table in sorted(tables):
        if name == 'rates' and table == 'commands.csv':
            continue  # over ROS a command between two ticks has the time of the first
        expected = (folder / 'offline' / 'csv' / table).read_bytes()
        assert (folder / 'ros' / 'csv' / table).read_bytes() == expected, table


@pytest.mark.parametrize(
    'name', [*LOCKSTEP, *(pytest.param(name, marks=pytest.mark.nightly) for name in NIGHTLY)]
)
def test_in_lockstep_a_run_over_ros_is_the_offline_run_to_the_last_byte(name, tmp_path, domain):
    lockstep_agrees(name, tmp_path)


@pytest.mark.nightly
@pytest.mark.parametrize('name', BUSY)
def test_so_it_is_on_a_busy_machine(name, tmp_path, domain):
    busy = [subprocess.Popen([sys.executable, '-c', 'while True: pass']) for _ in range(2)]
    try:
        lockstep_agrees(name, tmp_path)
    finally:
        for process in busy:
            process.kill()
            process.wait()
