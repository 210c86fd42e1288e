import itertools
from dataclasses import replace

import pytest

from setcmas_expe.lab.lab_file import DEFAULT_FILE, load_lab
from setcmas_expe.safety import body_proofs as proofs
from setcmas_expe.safety.body_proofs import CRAWL_M_S, PROOF_M, Proofs, Proving


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
    assert not proving.went(1, 0.06)
    assert not proving.went(1, -0.03)
    assert proving.went(1, 0.08)
    assert proving.allowed(1, 0.2, 0.4) == (0.2, 0.4)
    proving.doubt(1)
    assert proving.allowed(1, 0.2, 0.0) == (CRAWL_M_S, 0.0)


def test_others_wait_while_a_robot_that_is_doubted_wants_to_prove_itself():
    proving = Proving([1, 2], proved=[1, 2])
    proving.doubt(1)
    assert proving.allowed(1, 0.0, 0.0) == (0.0, 0.0)
    assert proving.allowed(2, 0.2, 0.0) == (0.2, 0.0)  # it has arrived, and shows nothing
    proving.allowed(1, 0.2, 0.0)
    assert proving.allowed(2, 0.2, 0.1) == (0.0, 0.0)
    assert proving.went(1, PROOF_M)
    assert proving.allowed(2, 0.2, 0.0) == (0.2, 0.0)


def test_robots_that_are_proved_need_no_proof():
    proving = Proving([1, 2], proved=[2])

    assert proving.left.keys() == {1}
    assert proving.allowed(2, 0.2, 0.0) == (0.2, 0.0)


LAB = load_lab(DEFAULT_FILE, 2)


@pytest.fixture
def file(tmp_path):
    return tmp_path / 'setcmas' / 'proved.yaml'


def test_proofs_last_for_the_same_bodies_only(file):
    assert Proofs(LAB, file).proved() == []
    Proofs(LAB, file).add([1, 2])

    assert Proofs(LAB, file).proved() == [1, 2]
    turned = replace(LAB, mocap=replace(LAB.mocap, y_up=True))
    assert Proofs(turned, file).proved() == []
    renamed = replace(LAB.robots[0], mocap_name='other')
    assert Proofs(replace(LAB, robots=(renamed, LAB.robots[1])), file).proved() == [2]
    Proofs(LAB, file).drop(1)
    assert Proofs(LAB, file).proved() == [2]


def test_old_proofs_and_broken_files_prove_nothing(file, monkeypatch):
    Proofs(LAB, file).add([1])
    monkeypatch.setattr(proofs, 'LASTING_S', 0.0)
    assert Proofs(LAB, file).proved() == []
    for text in ('[1, 2]', 'robot: [', 'robot 1: x'):
        file.write_text(text)
        assert Proofs(LAB, file).proved() == []
