"""Offline runs over graphs and imperfect links, compared with what theory says."""

import numpy as np
import pytest

from setcmas_ctrl import network
from setcmas_tools import simulate


def spread(run):
    """Return the largest distance of a robot to the fleet's centre, over time, in m."""
    positions = run.poses[:, :2]
    return np.hypot(*(positions - positions.mean(axis=2, keepdims=True)).swapaxes(0, 1)).max(
        axis=1
    )


def test_disagreement_of_event_triggered_robots_is_that_of_the_ros_1_stack():
    # 0.123 m was recorded after 40 s. It never rests, and one run is as good as another whose
    # robots start 1 mm away.
    starts = simulate('consensus', 8, 0.1).poses[0]
    errors = np.random.default_rng(0).normal(0.0, 0.001, (4, *starts.shape))
    options = {'nb_robots': 8, 'duration': 40.0, 'event_triggered': True}

    def disagreement(own_state, error):
        run = simulate('consensus', poses=starts + error, own_state=own_state, **options)
        return run.metrics()['consensus'].disagreement_at_end_m

    held = [disagreement('held', error) for error in errors]
    assert np.mean(held) == pytest.approx(0.12, abs=0.03)
    assert disagreement('exact', 0.0) < 0.03


def test_periodic_and_perfect_links_change_nothing():
    plain = simulate('consensus', 5, 20.0)
    matrix = simulate('consensus', 5, 20.0, graph=1.0 - np.eye(5))
    over_links = simulate('consensus', 5, 20.0, range=1000.0)

    assert plain.record is None
    assert matrix.record is None
    assert over_links.record.links
    np.testing.assert_array_equal(over_links.poses, plain.poses)


def test_a_condition_draws_the_same_numbers_in_each_run(tmp_path):
    script = tmp_path / 'random_condition.py'
    script.write_text(
        'import numpy as np\nrng = np.random.default_rng()\n\n'
        'def ctc(pos, last_pos, t):\n    return rng.random() < 0.3\n'
    )
    options = {'nb_robots': 3, 'duration': 3.0, 'event_triggered': True, 'ctc': script}
    first, second = (simulate('consensus', **options).record.triggers for _ in range(2))

    np.testing.assert_array_equal(first, second)
    assert (first[:31, 2] != first[31:62, 2]).any()


def test_a_message_is_received_at_the_next_call_whatever_the_order_of_robots():
    received = {}

    def control(robotNo, nbRobots, poses, t):
        received[robotNo, round(t, 6)] = {
            sender: (message.value, message.age) for sender, message in network.received().items()
        }
        network.send(100 * robotNo + round(5 * t))
        return 0, 0

    run = simulate(control, 3, 1.0, graph='path')

    assert received[2, 0.0] == received[1, 0.0] == {}
    assert received[2, 0.6] == {1: (102, 0.2), 3: (302, 0.2)}
    assert received[1, 0.6] == {2: (202, 0.2)}
    assert [(one.robot, one.value) for one in run.messages[:4]] == [
        (1, 100), (2, 200), (3, 300), (1, 101),
    ]  # fmt: skip


def test_robots_that_know_all_poses_have_links_from_the_first_message_on():
    def late(robotNo, nbRobots, poses, t):
        if t >= 0.95:
            network.send(1)
        return 0.1 * len(network.received()) if t >= 0.95 else 0.0, 0.0

    run = simulate(late, 3, 2.0)

    assert run.record.links[1, 2].sent == 10
    assert run.record.robots[1].sent == 21
    assert run.commands.of(1).vx[:6].tolist() == [0.0] * 6
    assert run.commands.of(1).vx[6:] == pytest.approx(0.2)
    assert simulate('consensus', 3, 2.0).record is None
