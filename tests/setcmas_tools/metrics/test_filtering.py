import numpy as np

from setcmas_tools.metrics.filtering import fleet_filtering
from setcmas_tools.records.commands import Commands, Filtered
from setcmas_tools.records.fleet_table import fleet_table
from setcmas_tools.records.tables import RunTables
from setcmas_tools.run.run import Run

FLEET = fleet_table([[0.0, 1, 0, 0, 0, 0, 0]])


def run_with(verdicts):
    """Return a run of two robots with the verdicts of each period of 0.2 s, shape (C, 2)."""
    count = len(verdicts)
    t, robot = np.repeat(0.2 * np.arange(count), 2), np.tile([1, 2], count)
    zeros = np.zeros(2 * count)
    allowed = Filtered(zeros, zeros, np.array(verdicts, dtype=float).ravel())
    return Run(RunTables(FLEET, Commands(t, robot, zeros, zeros, allowed)))


def test_times_are_those_of_each_robot():
    found = fleet_filtering(run_with([[0, 1], [1, 2], [2, 2], [3, 3]]))

    assert found.overruled_s == {1: 0.6, 2: 0.8}
    assert found.blocked_s == {1: 0.4, 2: 0.6}
    assert found.lines(None) == ['safety filter: no solution in 1 step, robots stood']


def test_a_run_without_a_filter_has_none():
    zero = np.zeros(1)
    assert (
        fleet_filtering(Run(RunTables(FLEET, Commands(zero, zero.astype(int), zero, zero))))
        is None
    )
