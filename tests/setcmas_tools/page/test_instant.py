import math
from dataclasses import replace

import numpy as np
import pytest

from setcmas_ctrl.filter.barrier import Verdict
from setcmas_tools.offline.engine import simulate
from setcmas_tools.page.history import RunHistory
from setcmas_tools.page.instant import Instants, Knowledge
from setcmas_tools.run.run import Run


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


def test_what_cannot_be_told_is_not_made_up():
    run, _ = witnessed(**CASES['lossy'])
    over_ros = replace(run, info=replace(run.info, started='2026-11-21T16:02:11+0000'))
    unknown = replace(run, info=replace(run.info, scenario={}))
    otherwise = replace(run, info=replace(run.info, scenario={**run.parameters, 'seed': 4}))

    for one, word in ((over_ros, 'real time'), (unknown, 'delayed'), (otherwise, 'another way')):
        known, reason = Knowledge(RunHistory(one)).of(1, 3.0)
        assert known is None
        assert reason.startswith('not recorded: ')
        assert word in reason
