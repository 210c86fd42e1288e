import numpy as np

from setcmas_tools.offline.engine import simulate
from setcmas_tools.page.run_history import RunHistory
from setcmas_tools.run.fleet_motion import fleet_table
from setcmas_tools.run.law_output import safety_record
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_tables import RunTables


def history_of(rows, **tables):
    return RunHistory(Run(RunTables(fleet_table(rows), **tables)))


def test_at_the_times_of_the_table_it_is_the_table(tmp_path):
    run = Run.load(simulate('consensus', 5, 10.0).save(tmp_path / 'run'))
    history = RunHistory(run)
    table = run.table

    assert (history.t0, history.t1) == (0.0, 10.0)
    for row in range(0, len(table.t), 7):
        t, column = table.t[row], history.robots.index(table.robot[row])
        x, y, theta = history.poses_at(np.array([t]))[:, 0, column]
        assert (x, y) == (table.x[row], table.y[row])
        assert abs(np.exp(1j * theta) - np.exp(1j * table.theta[row])) < 1e-12
        speeds = history.speeds_at(np.array([t]))[:, 0, column]
        assert speeds.tolist() == [table.v[row], table.omega[row]]


def test_between_two_poses_robots_are_between_them():
    history = history_of([[0.0, 1, 0, 0, 3.0, 0.0, 0.0], [0.5, 1, 1, 1, -3.0, 2.0, 0.3]])
    x, y, theta = history.poses_at(np.array([0.25]))[:, 0, 0]

    assert (x, y) == (0.5, 0.5)
    assert theta == np.pi
    assert history.speeds_at(np.array([0.25]))[:, 0, 0].tolist() == [2.0, 0.3]


def test_gaps_and_resets_stay_gaps():
    rows = [[t, 1, 0.2 * t, 0, 0, 0.2, 0] for t in np.arange(0, 10, 0.1)]
    rows = [row for row in rows if not 3.05 < row[0] < 6.05]
    rows += [[t, 1, 5.0, 0, 0, 0.2, 0] for t in np.arange(10, 12, 0.1)]
    history = history_of(rows)

    assert np.isnan(history.poses_at(np.array([4.0, 9.95]))).all()
    assert np.isnan(history.speeds_at(np.array([4.0]))).all()
    assert history.put(2.9, 6.2) == {1}
    assert history.put(9.5, 9.9) == set()
    assert history.put(9.9, 10.0) == {1}


def test_states_of_an_experiment():
    rows = [[t, 1, 0, 0, 0, 0, 0] for t in np.arange(-1, 3, 0.1)]
    record = safety_record([(0.0, 1, 'paused', True), (1.0, 1, 'moving', False)])
    history = history_of(rows, safety=record)

    assert history.t0 == 0.0
    assert history.safety(1, 0.5) == ('paused', True)
    assert history.safety(1, 1.0) == ('moving', False)
    assert history.safety(1, 2.5) is None
    assert history.safety(1, -0.5) is None
