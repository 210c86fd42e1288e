"""Runs over ROS and offline runs of the same law and options go the same way."""

import contextlib
import math
import os
import subprocess

import numpy as np
import pytest
import yaml
from processes import SETCMAS
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

QUICK = ('traj_tracking', 'a switching graph, late')
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
            output, _ = run.communicate(timeout=180)
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


@pytest.mark.parametrize(
    ('names', 'duration'), [(QUICK, 15.0), pytest.param(RUNS, 40.0, marks=pytest.mark.nightly)]
)
def test_ros_and_offline_runs_agree(names, duration, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'switching.yaml').write_text(SWITCHING)
    run_over_ros(names, duration, tmp_path)
    rms = {name: apart(name, duration, tmp_path) for name in names}
    # A machine that is busy with other tests delays commands, or starts; then one run at a time.
    for name in [name for name in names if rms[name] >= LARGEST_RMS_M]:
        for _ in range(3):
            run_over_ros([name], duration, tmp_path)
            rms[name] = apart(name, duration, tmp_path)
            if rms[name] < LARGEST_RMS_M:
                break
    print(rms)
    assert max(rms.values()) < LARGEST_RMS_M, rms
