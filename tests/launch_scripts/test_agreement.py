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


@pytest.fixture(scope='module')
def ros_runs(tmp_path_factory):
    """Run all laws over ROS at the same time, each fleet in a domain of its own."""
    folder = tmp_path_factory.mktemp('runs')
    with contextlib.ExitStack() as stack:
        runs = []
        for algo, nb_robots in FLEETS.items():
            domain = stack.enter_context(reserved_domain())
            options = ['--nb-robots', str(nb_robots), '--duration', str(DURATION), '-o', algo]
            environment = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_DOMAIN_ID': domain}
            run = subprocess.Popen(
                [*SETCMAS, 'run', '--algo', algo, *options],
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
    return folder


@pytest.mark.parametrize('algo', FLEETS)
def test_ros_and_offline_runs_agree(ros_runs, algo):
    nb_robots = FLEETS[algo]
    offline = simulate(algo, nb_robots, DURATION)
    table = read_csv(ros_runs / algo / 'csv' / 'fleet.csv')
    tracks = [table.of(robot) for robot in table.robots]
    over_ros = np.array(
        [np.interp(offline.t, track.t, axis) for track in tracks for axis in (track.x, track.y)]
    )
    ours = offline.poses[:, :2].transpose(2, 1, 0).reshape(2 * nb_robots, -1)

    comparison = compare(offline.t, ours, offline.t, over_ros)

    assert len(tracks) == nb_robots
    print(algo, comparison, comparison.rms / np.sqrt(nb_robots))
    assert comparison.rms / np.sqrt(nb_robots) < 0.08
