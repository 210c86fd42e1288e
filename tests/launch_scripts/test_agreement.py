"""Runs over ROS and offline runs of the same law from the same start go the same way."""

import contextlib
import os
import subprocess

import numpy as np
import pytest
from processes import SETCMAS
from ros_domain import reserved_domain

from setcmas_tools import simulate
from setcmas_tools.fleet_table import read_csv
from setcmas_tools.trajectory_comparison import compare

pytest.importorskip('rclpy')

DURATION = 40.0
FLEETS = {
    'nav_wp': 2,
    'traj_tracking': 2,
    'consensus': 8,
    'leader_follower_formation': 5,
    'leader_follower_distance_formation': 4,
}


LARGEST_RMS_M = 0.08  # per robot


def run_over_ros(laws, folder):
    """Run laws at the same time, each fleet in a domain of its own."""
    with contextlib.ExitStack() as stack:
        runs = []
        for algo in laws:
            domain = stack.enter_context(reserved_domain())
            options = ['--nb-robots', str(FLEETS[algo]), '--duration', str(DURATION)]
            environment = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_DOMAIN_ID': domain}
            run = subprocess.Popen(
                [*SETCMAS, 'run', '--algo', algo, *options, '-o', algo, '--overwrite'],
                cwd=folder,
                env={**os.environ, **{name: str(value) for name, value in environment.items()}},
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
            )
            stack.callback(run.kill)
            runs.append(run)
        for run in runs:
            output, _ = run.communicate(timeout=180)
            assert run.returncode == 0, output.decode()


def apart(algo, folder):
    """Return how far (m, RMS per robot) a run over ROS is from the offline run."""
    nb_robots = FLEETS[algo]
    offline = simulate(algo, nb_robots, DURATION)
    table = read_csv(folder / algo / 'csv' / 'fleet.csv')
    tracks = [table.of(robot) for robot in table.robots]
    assert len(tracks) == nb_robots
    over_ros = np.array(
        [np.interp(offline.t, track.t, axis) for track in tracks for axis in (track.x, track.y)]
    )
    ours = offline.poses[:, :2].transpose(2, 1, 0).reshape(2 * nb_robots, -1)
    return compare(offline.t, ours, offline.t, over_ros).rms / np.sqrt(nb_robots)


def test_ros_and_offline_runs_agree(tmp_path):
    run_over_ros(FLEETS, tmp_path)
    rms = {algo: apart(algo, tmp_path) for algo in FLEETS}
    # A machine that is busy with other tests delays commands; then one law at a time.
    for algo in [algo for algo in FLEETS if rms[algo] >= LARGEST_RMS_M]:
        for _ in range(3):
            run_over_ros([algo], tmp_path)
            rms[algo] = apart(algo, tmp_path)
            if rms[algo] < LARGEST_RMS_M:
                break
    print(rms)
    assert max(rms.values()) < LARGEST_RMS_M, rms
