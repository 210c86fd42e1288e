import numpy as np
import pytest

from setcmas_ctrl.communication.delay_and_loss import Channel, Links
from setcmas_ctrl.communication.graph import complete, directed_ring, path

POSES = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [0.1, 0.2, 0.3]])
ALL = [0, 1, 2]


def begun(graph=None, receivers=(1, 2, 3), seed=0, holds_own=False, **channel):
    """Links of 3 robots that have sent their poses at the start."""
    links = Links(receivers, 3, Channel(**channel), seed, holds_own)
    links.send(ALL, POSES, -0.1)
    links.begin(complete(3) if graph is None else graph)
    return links


def moved(k):
    return POSES + np.array([[0.1 * k], [0.0], [0.0]])


def test_a_robot_always_knows_its_own_pose_exactly():
    links = begun(np.zeros((3, 3)), loss=1.0, noise=1.0, delay=5.0)
    own = moved(7)

    known = links.known_poses(own, 1.0)

    for robot in range(3):
        np.testing.assert_array_equal(known[robot, :, robot], own[:, robot])
    assert np.isfinite(known).sum() == 9


def test_a_robot_that_holds_its_own_state_knows_the_pose_that_it_sent_last():
    links = begun(receivers=(2, 3), holds_own=True, loss=1.0, noise=1.0, delay=5.0)
    links.send([1], moved(4)[:, [1]], 0.1)

    known = links.known_poses(moved(7)[:, 1:], 0.1)

    np.testing.assert_array_equal(known[0, :, 1], moved(4)[:, 1])
    np.testing.assert_array_equal(known[1, :, 2], POSES[:, 2])


def test_a_delayed_message_counts_when_it_arrives():
    links = begun(delay=0.3)
    seen = []
    for k in range(1, 9):
        links.send(ALL, moved(k), 0.1 * k)
        seen.append(links.known_poses(moved(9), 0.1 * k)[0, 0, 1])

    assert seen == pytest.approx([2.0, 2.0, 2.0, 2.1, 2.2, 2.3, 2.4, 2.5])
    assert links.counts.received[0, 1] == 5
    assert links.counts.last[0, 1] == pytest.approx(0.8)
    assert links.counts.mean_interval[0, 1] == pytest.approx(0.1)


def test_all_is_lost_on_a_dead_link_and_the_start_is_known():
    links = begun(loss=1.0)
    for k in range(1, 11):
        links.send(ALL, moved(k), 0.1 * k)

    np.testing.assert_array_equal(links.known_poses(POSES, 2.0)[0], POSES)
    assert (links.counts.lost == 10 * (1 - np.eye(3))).all()
    assert np.isnan(links.counts.mean_interval).all()


def test_the_ratio_of_losses_is_the_one_asked_for():
    links = begun(loss=0.3)
    for k in range(3000):
        links.send(ALL, POSES, 0.1 * k)
    ratio = links.counts.lost.sum() / links.counts.sent.sum()

    assert (links.counts.sent == 3000 * (1 - np.eye(3))).all()
    assert (links.counts.sent == links.counts.lost + links.counts.received).all()
    assert ratio == pytest.approx(0.3, abs=5 * np.sqrt(0.21 / 18000))


def test_noise_has_the_deviation_asked_for_and_spares_the_heading():
    links = begun(noise=0.02)
    errors = []
    for k in range(2000):
        links.send(ALL, POSES, 0.1 * k)
        errors.append(links.known_poses(POSES, 0.1 * k)[0] - POSES)
    errors = np.array(errors)

    assert (errors[:, 2] == 0).all()
    assert (errors[:, :, 0] == 0).all()
    assert errors[:, :2, 1:].std() == pytest.approx(0.02, rel=0.05)
    assert abs(errors[:, :2, 1:].mean()) < 5 * 0.02 / np.sqrt(8000)
    assert abs(np.corrcoef(errors[:, 0, 1], errors[:, 1, 1])[0, 1]) < 0.12
    assert abs(np.corrcoef(errors[:-1, 0, 1], errors[1:, 0, 1])[0, 1]) < 0.12


def outcome(links, order, receivers=ALL):
    for k in range(50):
        for sender in order:
            links.send([sender], moved(k)[:, [sender]], 0.1 * k)
    return links.known_poses(POSES[:, receivers], 9.0).copy(), links.counts.lost.copy()


def test_what_happens_to_a_message_depends_on_its_link_and_number_only():
    imperfect = {'loss': 0.4, 'noise': 0.1}
    known, lost = outcome(begun(**imperfect), ALL)
    again, lost_again = outcome(begun(**imperfect), [2, 0, 1])
    of_robot_2, lost_of_robot_2 = outcome(begun(receivers=[2], **imperfect), ALL, [1])

    np.testing.assert_array_equal(known, again)
    np.testing.assert_array_equal(lost, lost_again)
    np.testing.assert_array_equal(known[1:2], of_robot_2)
    np.testing.assert_array_equal(lost[1:2], lost_of_robot_2)


def test_links_that_come_up_elsewhere_change_nothing():
    known = []
    for receivers in ([1, 2, 3], [3]):
        links = Links(receivers, 3, Channel(noise=0.1, loss=0.5), 0)
        links.send(ALL, POSES, -0.1)
        links.begin(path(3))
        for k in range(20):
            links.connect(complete(3) if k % 2 else directed_ring(3), 0.1 * k)
            links.send(ALL, moved(k), 0.1 * k)
        known.append(links.known_poses(POSES[:, np.array(receivers) - 1], 9.0)[-1])

    np.testing.assert_array_equal(*known)


def test_seeds_and_links_are_independent():
    _, lost = outcome(begun(loss=0.5), ALL)
    _, other = outcome(begun(loss=0.5, seed=1), ALL)

    assert len(np.unique(lost[lost > 0])) > 2
    assert (lost != other).any()


def test_a_link_that_comes_up_brings_the_state_sent_last():
    links = begun(directed_ring(3), delay=0.2)  # robot 1 receives from robot 2
    links.send([2], moved(5)[:, [2]], 1.0)
    links.connect(complete(3), 2.0)

    assert np.isnan(links.known_poses(POSES, 2.1)[0, 0, 2])
    assert links.known_poses(POSES, 2.2)[0, 0, 2] == 3.5
    assert links.counts.sent[0].tolist() == [0, 0, 1]


def test_a_link_that_goes_down_forgets_and_loses_what_is_on_its_way():
    links = begun(delay=0.2)
    links.send(ALL, moved(1), 1.0)
    links.connect(path(3), 1.1)
    known = links.known_poses(moved(1), 1.2)

    assert np.isnan(known[0, :, 2]).all()
    assert known[0, 0, 1] == 2.1
    assert links.counts.lost.tolist() == [[0, 0, 1], [0, 0, 0], [1, 0, 0]]


def test_what_arrives_before_its_link_goes_down_is_not_lost():
    links = begun(delay=0.2)
    links.send(ALL, moved(1), 1.0)
    links.connect(path(3), 1.2)

    assert np.isnan(links.known_poses(moved(1), 1.2)[0, :, 2]).all()
    assert links.counts.lost.sum() == 0
    assert (links.counts.received == 1 - np.eye(3)).all()


def test_nothing_is_known_of_a_robot_that_never_sent():
    links = Links([1], 3, Channel(), 0)
    links.send([1], POSES[:, [1]], 0.0)
    links.begin(complete(3))

    assert np.isnan(links.last_sent[0]).tolist() == [True, False, True]
    assert np.isnan(links.known_poses(POSES[:, [0]], 0.0)[0, 0]).tolist() == [False, False, True]


def test_content_shares_delay_and_loss_of_its_state():
    links = begun(delay=0.3, loss=0.5, seed=3)
    arrived = []
    for k in range(1, 30):
        links.attach(1, k)
        links.send(ALL, moved(k), 0.1 * k)
        known = links.known_poses(moved(k), 0.1 * k)[0, 0, 1]
        content = links.contents(0).get(1)
        arrived.append(content)
        assert content is None or known == moved(content)[0, 1]

    assert 5 < len(set(arrived)) < 20  # some were lost
    assert links.counts.lost[0, 1] > 5


def test_a_link_that_goes_down_loses_content_and_later_has_that_of_the_last_state():
    links = begun()
    links.attach(2, 'old')
    links.send(ALL, POSES, 0.1)
    links.connect(np.zeros((3, 3)), 0.2)
    assert links.contents(0) == {}

    links.attach(2, 'new')  # not sent yet
    links.connect(complete(3), 0.3)

    assert links.contents(0) == {2: 'old'}


def test_forgotten_contents_do_not_arrive():
    links = begun(delay=0.3)
    links.attach(2, 'old')
    links.send(ALL, POSES, 0.1)
    links.forget_contents()
    links.attach(1, 'new')
    links.known_poses(POSES, 1.0)

    assert links.contents(0) == {}


def test_contents_sent_before_the_start_are_known():
    links = Links([1, 2, 3], 3, Channel(delay=1.0), 0)
    links.attach(2, 'early')
    links.send(ALL, POSES, -0.1)
    links.begin(path(3))

    assert [links.contents(robot) for robot in range(3)] == [{}, {2: 'early'}, {}]
