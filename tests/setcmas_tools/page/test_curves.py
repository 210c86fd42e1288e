import numpy as np
from runs import run_of

from setcmas_tools.measures.consensus_metrics import fleet_consensus
from setcmas_tools.measures.safety_metrics import fleet_separation
from setcmas_tools.offline.engine import simulate
from setcmas_tools.page.curves import FLEET, curves, difference
from setcmas_tools.run.fleet_motion import fleet_table


def test_they_are_what_metrics_tell():
    run = simulate('consensus', 4, 20.0)
    found = {curve.name: curve for curve in curves(run)}

    assert list(found) == ['Disagreement', 'Least separation', 'Speed']
    told = fleet_consensus(run)
    values = found['Disagreement'].values[FLEET]
    assert (values[0], values[-1]) == (told.disagreement_at_start_m, told.disagreement_at_end_m)
    least = fleet_separation(run).least_separation_m
    assert least <= found['Least separation'].values[FLEET].min() < least + 0.01
    np.testing.assert_array_equal(found['Speed'].values[3], run['tb3_3'].v)
    np.testing.assert_allclose(found['Speed'].t, run['tb3_3'].t)


def test_a_task_has_errors():
    error = curves(simulate('traj_tracking', 1, 30.0))[-1]

    assert error.name == 'Tracking error'
    assert error.values[1][-1] < 0.1 * error.values[1].max()


def test_the_difference_of_two_runs():
    run, other = simulate('consensus', 3, 10.0), simulate('consensus', 4, 12.0, vnom=0.3)
    apart = difference(run, other)

    assert list(apart.values) == [1, 2, 3]
    assert apart.t[-1] == 10.0
    xy = run.poses[50, :2, 1] - other.poses[50, :2, 1]
    assert np.isclose(apart.values[2][50], np.hypot(*xy))
    assert apart.values[2][0] == 0.0


def test_there_is_no_speed_in_a_gap():
    rows = [[t, 1, 0.2 * t, 0, 0, 0.2, 0] for t in np.arange(100) / 10 if not 3.05 < t < 6.05]
    (speed,) = curves(run_of(fleet_table(rows)))

    gap = (speed.t > 3.05) & (speed.t < 6.05)
    assert np.isnan(speed.values[1][gap]).all()
    np.testing.assert_allclose(speed.values[1][~gap], 0.2)
