import math

import numpy as np

from setcmas_ctrl.filter.barrier import Verdict
from setcmas_tools import Run, simulate
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.replay.instant import Instants


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
    assert divides.failure.text.startswith('test_instant.py, line 13: ZeroDivisionError')
    assert (divides.failure.line, divides.failure.script) == (13, 'test_instant.py')
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
