import math
from dataclasses import replace

import numpy as np
import pytest
from runs import run_of

from setcmas_ctrl.filter.safety_filter import Verdict
from setcmas_tools.measures.consensus_metrics import fleet_consensus
from setcmas_tools.measures.safety_metrics import fleet_separation
from setcmas_tools.offline.engine import simulate
from setcmas_tools.page.instant import FLEET, Instants, Knowledge, curves, difference
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
    assert history.newest(0.25)[:, 0].tolist() == [0, 0, 3.0]


def test_gaps_and_resets_stay_gaps():
    rows = [[t, 1, 0.2 * t, 0, 0, 0.2, 0] for t in np.arange(0, 10, 0.1)]
    rows = [row for row in rows if not 3.05 < row[0] < 6.05]
    rows += [[t, 1, 5.0, 0, 0, 0.2, 0] for t in np.arange(10, 12, 0.1)]
    history = history_of(rows)

    assert np.isnan(history.poses_at(np.array([4.0, 9.95]))).all()
    assert np.isnan(history.speeds_at(np.array([4.0]))).all()
    assert history.newest(4.0)[0, 0] == 0.2 * 3.0
    assert history.put(2.9, 6.2) == {1}
    assert history.put(9.5, 9.9) == set()
    assert history.put(9.9, 10.0) == {1}


def test_links_as_they_were():
    def control(robot, nb_robots, poses, t):
        return tuple(-poses[:2, robot - 1])

    run = simulate(control, 3, 20.0, graph='path', range=5.0, event_triggered=True)
    history = RunHistory(run)

    assert history.adjacency(20.0).tolist() == [[0, 1, 0], [1, 0, 1], [0, 1, 0]]
    assert not history.adjacency(0.0).any()
    assert RunHistory(simulate('consensus', 3, 1.0)).adjacency(0.5) is None


def test_states_of_an_experiment():
    rows = [[t, 1, 0, 0, 0, 0, 0] for t in np.arange(-1, 3, 0.1)]
    record = safety_record([(0.0, 1, 'paused', True), (1.0, 1, 'moving', False)])
    history = history_of(rows, safety=record)

    assert history.t0 == 0.0
    assert history.safety(1, 0.5) == ('paused', True)
    assert history.safety(1, 1.0) == ('moving', False)
    assert history.safety(1, 2.5) is None
    assert history.safety(1, -0.5) is None


def test_they_equal_the_metrics():
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


def failing(robot, nb_robots, poses, t):
    if robot == 2 and 2.0 <= t < 4.0:
        return (1.0 / 0.0, 0.0) if t < 3.0 else None
    return 2.0 if t < 6.0 else 0.2, 0.0


def test_a_law_that_fails_for_a_while(tmp_path):
    run = Run.load(simulate(failing, 2, 8.0, warn=lambda _: None).save(tmp_path / 'run'))
    instants = Instants(RunHistory(run))
    works, divides, returns = (instants.of(2, t) for t in (1.0, 2.5, 3.9))

    assert works.failure is None
    assert works.wanted == (0.5, 0.0)
    assert works.saturated
    line = failing.__code__.co_firstlineno + 2
    assert divides.failure.text.startswith(f'test_instant.py, line {line}: ZeroDivisionError')
    assert (divides.failure.line, divides.failure.script) == (line, 'test_instant.py')
    assert (divides.failure.t, divides.failure.until) == (2.0, 3.0)
    assert 'control returned None' in returns.failure.text
    assert divides.wanted == (0.0, 0.0)
    assert not divides.saturated
    assert instants.of(2, 4.0).failure is None
    assert instants.of(1, 2.5).failure is None
    late = instants.of(1, 6.35)
    assert late.called_at == 6.2
    assert math.isclose(late.wanted[0], 0.2, rel_tol=1e-6)
    assert not late.saturated


def test_what_a_filter_let_through():
    run = simulate('nav_wp', 3, 20.0, filter='barrier', min_separation=0.5)
    changed = np.flatnonzero(run.commands.allowed.verdict == Verdict.CHANGED)
    row = changed[len(changed) // 2]
    one = Instants(RunHistory(run)).of(int(run.commands.robot[row]), float(run.commands.t[row]))

    assert one.verdict is Verdict.CHANGED
    assert one.overruled
    assert one.allowed == (run.commands.allowed.vx[row], run.commands.allowed.vy[row])
    assert one.allowed != one.wanted


def test_what_is_not_recorded_is_none(tmp_path):
    path = simulate('consensus', 2, 3.0).save(tmp_path / 'run')
    (path / 'csv' / 'commands.csv').unlink()
    one = Instants(RunHistory(Run.load(path))).of(1, 1.0)

    assert (one.wanted, one.allowed, one.saturated, one.verdict) == (None,) * 4
    assert (one.state, one.overruled, one.called_at) == (None,) * 3
    assert one.known.shape == (3, 2)


RING = {'graph': 'ring'}
CASES = {
    'ideal': {},
    'ring': RING,
    'late': {'delay': 0.25},
    'lossy': RING | {'loss': 0.4, 'delay': 0.15},
    'noisy': {'noise': 0.1},
    'by_event': RING | {'event_triggered': True, 'delay': 0.1, 'loss': 0.2},
    'near': {'range': 6.0, 'loss': 0.1},
}


def witnessed(**options):
    """Simulate a law that keeps what it was told; returns the run and that by robot and time."""
    told = {}

    def control(robot, nb_robots, poses, t):
        told[robot, t] = poses.copy()
        heard = np.nan_to_num(poses[:2] - poses[:2, robot - 1 : robot])
        return tuple(heard.mean(axis=1) + 0.1 * robot)

    return simulate(control, 4, 12.0, seed=3, **options), told


@pytest.mark.parametrize('case', CASES)
def test_it_is_what_each_law_was_given(case, tmp_path):
    run, told = witnessed(**CASES[case])
    loaded = Run.load(run.save(tmp_path / 'run'))
    knowledge = Knowledge(RunHistory(loaded))

    assert len(told) == 4 * 60
    for (robot, t), poses in told.items():
        known, reason = knowledge.of(robot, t)
        assert not reason
        np.testing.assert_allclose(known, poses, atol=1e-8)


def test_links_that_come_and_go(tmp_path):
    graph = tmp_path / 'graph.yaml'
    graph.write_text(
        'repeat: true\nsegments:\n'
        '- {duration: 2, edges: [1 - 2]}\n- {duration: 3, edges: [3 - 4, 2 <- 3]}\n'
    )
    run, told = witnessed(graph=graph, delay=0.3, loss=0.2)
    knowledge = Knowledge(RunHistory(run))

    for (robot, t), poses in told.items():
        np.testing.assert_allclose(knowledge.of(robot, t)[0], poses, atol=1e-12)


def test_between_two_calls_it_is_that_of_the_first_one_but_for_itself():
    run, told = witnessed(**RING)
    known, _ = Knowledge(RunHistory(run)).of(2, 5.15)

    np.testing.assert_array_equal(known[:, 0], told[2, 5.0][:, 0])
    np.testing.assert_array_equal(known[:, 1], run.poses[51, :, 1])


def test_unknown_values_are_not_made_up():
    run, _ = witnessed(**CASES['lossy'])
    over_ros = replace(run, info=replace(run.info, started='2026-11-21T16:02:11+0000'))
    unknown = replace(run, info=replace(run.info, scenario={}))
    otherwise = replace(run, info=replace(run.info, scenario={**run.parameters, 'seed': 4}))

    for one, word in (
        (over_ros, 'real time'),
        (unknown, 'delayed'),
        (otherwise, 'do not reproduce'),
    ):
        known, reason = Knowledge(RunHistory(one)).of(1, 3.0)
        assert known is None
        assert reason.startswith('not recorded: ')
        assert word in reason
