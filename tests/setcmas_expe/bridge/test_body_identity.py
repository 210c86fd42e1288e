import itertools

import pytest

from setcmas_expe.bridge.body_identity import (
    CRAWL_M_S,
    PROOF_M,
    PROOF_RAD,
    SLOW_TURN_RAD_S,
    Proving,
)


def turns(nb_robots, seconds=12.0, step=0.05):
    """Return for each robot when it may move."""
    proving = Proving(range(1, nb_robots + 1))
    moves = {robot: [] for robot in range(1, nb_robots + 1)}
    for _ in range(round(seconds / step)):
        for robot, may in moves.items():
            may.append(proving.allowed(robot, 0.2, 0.0)[0] > 0)
        proving.go_on(step)
    return moves


@pytest.mark.parametrize('nb_robots', [2, 3, 8, 50])
def test_any_two_robots_move_at_different_times_and_each_as_long(nb_robots):
    moves = turns(nb_robots)

    for one, other in itertools.combinations(moves, 2):
        alone = sum(a and not b for a, b in zip(moves[one], moves[other], strict=True))
        assert alone * 0.05 >= 0.6
    assert all(sum(may) * 0.05 * CRAWL_M_S >= PROOF_M - 0.01 for may in moves.values())


def test_one_robot_crawls_without_a_break_until_it_is_proved():
    proving = Proving([1])

    assert proving.allowed(1, 0.2, 0.4) == pytest.approx((CRAWL_M_S, 0.1))
    assert not proving.went(1, 0.06, PROOF_RAD)
    assert not proving.went(1, -0.03, 0.0)
    assert proving.went(1, 0.08, 0.0)
    assert proving.allowed(1, 0.2, 0.4) == (0.2, 0.4)
    proving.end(1)
    assert proving.allowed(1, 0.2, 0.0) == (CRAWL_M_S, 0.0)


def test_a_robot_turns_slowly_on_its_curve_until_its_turning_is_proved_and_drives_straight_fast():
    proving = Proving([1])
    assert proving.went(1, PROOF_M, 0.0)
    assert proving.allowed(1, 0.2, 0.0) == (0.2, 0.0)
    assert proving.allowed(1, 0.2, -SLOW_TURN_RAD_S) == (0.2, -SLOW_TURN_RAD_S)
    assert proving.allowed(1, 0.2, 1.5) == pytest.approx((0.2 * SLOW_TURN_RAD_S / 1.5, 0.3))
    proving.went(1, 0.5, -2 * PROOF_RAD)  # no debt
    proving.went(1, 0.5, 0.9 * PROOF_RAD)
    proving.went(1, 0.5, -0.3 * PROOF_RAD)
    assert proving.allowed(1, 0.0, 2.0)[1] == pytest.approx(SLOW_TURN_RAD_S)
    proving.went(1, 0.0, 0.4 * PROOF_RAD)
    assert proving.allowed(1, 0.2, 1.5) == (0.2, 1.5)
    proving.end(1)
    assert proving.allowed(1, 0.0, 1.5) == pytest.approx((0.0, SLOW_TURN_RAD_S))
