import numpy as np
import pytest
from report_pages import unpacked
from runs import run_of

from setcmas_tools.replay.history import RunHistory
from setcmas_tools.report.motion import common_times, fleet_entry
from setcmas_tools.run.fleet_motion import fleet_table


def history_of(t, nb_robots=1, x=0.0):
    rows = [
        np.array(np.broadcast_arrays(t, robot, x, robot, 0.0, 0.5, 0.0)).T
        for robot in range(1, nb_robots + 1)
    ]
    return RunHistory(run_of(fleet_table(np.concatenate(rows))))


def test_poses_and_speeds_are_those_of_the_table(failed_run):
    history = RunHistory(failed_run)
    t = common_times(history)

    assert t.tolist() == [k / 10 for k in range(41)]
    for entry in fleet_entry(history, t):
        rows = failed_run[entry['number']]
        for name in ('x', 'y', 'v', 'omega'):
            assert np.allclose(unpacked(entry[name]), getattr(rows, name), rtol=0, atol=6e-5)
        assert entry['breaks'] == []


def test_a_robot_that_is_put_elsewhere_leaves_a_gap():
    t = np.arange(21) / 10
    history = history_of(t, x=np.where(t < 1.0, 0.5 * t, 9.0 + 0.5 * t))

    [entry] = fleet_entry(history, common_times(history))

    assert entry['breaks'] == [10]


@pytest.mark.parametrize(
    ('t', 'nb_robots', 'times'),
    [
        (np.arange(0.0, 3600.0), 100, np.arange(0.0, 3600.0, 5.0)),
        (np.array([0.0]), 1, [0.0]),
        (np.array([0.34, 0.36]), 1, [0.34]),
        (np.array([-2.0, 0.0, 0.3]), 1, [0.0, 0.1, 0.2, 0.3]),
    ],
)
def test_times_are_few_enough_for_a_mail_and_begin_with_the_first_command(t, nb_robots, times):
    assert np.allclose(common_times(history_of(t, nb_robots)), times)
