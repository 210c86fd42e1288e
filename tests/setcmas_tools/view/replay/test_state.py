import numpy as np
from runs import run_of

from setcmas_tools import simulate
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.run.fleet_motion import fleet_table
from setcmas_tools.view.model.robot_states import ERROR, WARN
from setcmas_tools.view.replay.state import ReplayedState


def test_a_fleet_is_where_it_was():
    run = simulate('consensus', 4, 10.0, graph='ring', event_triggered=True)
    state = ReplayedState(RunHistory(run))
    sent = float(run.record.trigger_times[1][2])
    state.move_to(sent)
    row = int(np.flatnonzero(np.isclose(run.t, sent))[0])

    assert state.fleet.robots == [1, 2, 3, 4]
    np.testing.assert_allclose(state.fleet.poses(sent), run.poses[row], atol=1e-12)
    np.testing.assert_array_equal(state.fleet.speeds(), run.V[row])
    assert state.flashes.strength([1, 2], sent)[0] == 1.0
    assert state.both.tolist() == [[1, 2], [1, 4], [2, 3], [3, 4]]
    assert state.clock.seconds(sent) == sent


def test_a_robot_that_is_silent_stays_where_it_was_seen_last_and_is_lost():
    rows = [[t, 1, 0.1 * t, 0, 0, 0.1, 0] for t in np.arange(0, 12, 0.1)]
    rows += [[t, 2, 5 - 0.1 * t, 0, 0, 0.1, 0] for t in np.arange(2, 12, 0.1) if not 3.95 < t < 8]
    state = ReplayedState(RunHistory(run_of(fleet_table(rows))))

    state.move_to(1.0)
    assert state.fleet.robots == [1]
    state.move_to(5.0)
    assert state.fleet.lost(5.0).tolist() == [False, False]
    state.move_to(7.0)
    assert state.fleet.lost(7.0).tolist() == [False, True]
    assert np.isclose(state.fleet.poses(7.0)[0, 1], 5 - 0.1 * 3.9)
    state.fleet.take_put()
    state.move_to(8.5)
    assert state.fleet.take_put() == {2}
    past = list(state.past(8.0))
    assert {2} in [put for *_, put in past]
    assert past[-1][2].tolist() == state.fleet.poses(8.5)[:2].tolist()


def test_failed_and_kept_clear_in_words():
    def control(robot, nb_robots, poses, t):
        if robot == 1 and t > 1.0:
            return None
        return (0.5, 0.0) if robot == 2 else (-0.5, 0.0)

    starts = [[0.0, -1.0, 1.0], [3.0, 0.0, 0.0], [0.0, 0.0, 3.1]]
    run = simulate(control, 3, 4.0, poses=starts, filter='barrier', warn=lambda _: None)
    state = ReplayedState(RunHistory(run))
    state.move_to(3.5)

    level, told = state.states.describe(1, False, 0.0, 3.5)
    assert (level, told.partition(',')[0]) == (ERROR, 'failed: test_state.py')
    assert state.states.describe(2, False, 0.3, 3.5) in [(WARN, 'kept clear'), (WARN, 'blocked')]
