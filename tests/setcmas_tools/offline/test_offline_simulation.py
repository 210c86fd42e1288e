import numpy as np
import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools import simulate


def forward(robotNo, nbRobots, poses, t):
    return 0.3, 0.0


def test_shapes_and_times():
    run = simulate('consensus', nb_robots=3, duration=2.0)

    assert run.t.shape == (21,)
    assert run.poses.shape == (21, 3, 3)
    assert run.V.shape == run.omega.shape == (21, 3)
    np.testing.assert_allclose(run.control_t, np.arange(10) / 5)
    assert run.velocities.shape == (10, 2, 3)
    table = run.table
    np.testing.assert_array_equal(table.robot, [1, 2, 3] * 21)
    np.testing.assert_array_equal(table.of(3).x, run.poses[:, 0, 2])
    np.testing.assert_array_equal(table.of(3).theta, run.poses[:, 2, 2])
    np.testing.assert_array_equal(table.of(2).omega, run.omega[:, 1])


@pytest.mark.parametrize(
    ('rate', 'robot_rate', 'calls'), [(10, 10, 20), (3, 10, 6), (50, 10, 100)]
)
def test_other_rates(rate, robot_rate, calls):
    run = simulate(forward, duration=2.0, rate=rate, robot_rate=robot_rate)

    assert len(run.control_t) == calls
    np.testing.assert_allclose(run.control_t, np.arange(calls) / rate)
    assert run.poses[-1, 0, 0] == pytest.approx(0.6)


def test_between_two_states_of_the_robots_laws_see_the_older_one_and_command_the_next():
    seen = []

    def law(robotNo, nbRobots, poses, t):
        seen.append((round(t, 2), round(poses[0, 0], 3)))
        return (0.5, 0.0) if t > 0.2 else (0.1, 0.0)

    simulate(law, duration=0.6, rate=20 / 3)

    # The states are 0 m, 0.01 m (at t = 0.1 s), 0.02 m, 0.03 m, 0.08 m (at t = 0.4 s), ...
    assert seen == [(0.0, 0.0), (0.15, 0.01), (0.3, 0.03), (0.45, 0.08)]


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        ({'nb_robots': 0}, 'nb_robots is 0; it must be a whole number from 1 to 2000'),
        ({'duration': 0}, 'duration is 0; it must be above 0 s and finite'),
        ({'limits': 'segway'}, "limits is 'segway'; it must be ideal, burger or waffle"),
        ({'loss': 1.1}, r'loss is 1\.1; it must be from 0 to 1'),
        ({'pose': 5}, 'pose is 5; it must be a text'),
        ({'ctc': lambda: 0}, 'ctc needs event_triggered; add it'),
    ],
)
def test_arguments_are_checked_as_options_and_reported_as_arguments(arguments, message):
    with pytest.raises(SetcmasError, match=f'^{message}$'):
        simulate(forward, **arguments)


def test_a_robot_without_a_law_is_named():
    with pytest.raises(SetcmasError, match='algo has no control law for robots 2-3; add it'):
        simulate({1: forward}, nb_robots=3)


def test_inf_is_no_limit():
    def law(robotNo, nbRobots, poses, t):
        return 1e3, 0.0

    fast = simulate(law, duration=1.0, vnom=np.inf)

    assert fast.velocities[0, 0, 0] == 1e3
    assert simulate(law, 2, 1.0, range=np.inf).record is None


def test_a_failing_robot_stands_and_is_reported_once():
    said = []

    def law(robotNo, nbRobots, poses, t):
        return (1 / 0, 0) if robotNo == 2 and t < 0.7 else (0.1, 0.0)

    run = simulate(law, 2, 2.0, warn=said.append)

    assert (run.poses[:8, 0, 1] == run.poses[0, 0, 1]).all()
    assert run.poses[-1, 0, 1] > run.poses[0, 0, 1]
    assert len(said) == 2
    assert 'tb3_2 at t = 0.0 s' in said[0]
    assert 'ZeroDivisionError' in said[0]
    assert 'works again after 4 calls' in said[1]


def test_a_run_describes_itself_in_one_line():
    run = simulate(forward, 2, 1.0)
    assert repr(run) == 'Run(forward, 2 robots, 1 s, complete)'
    assert repr(run.table) == 'FleetTable(22 rows, 2 robots, 0 to 1 s)'
    assert repr(run.grid()) == 'FleetGrid(11 rows, 2 robots, 0 to 1 s)'
