import numpy as np

from setcmas_tools.view.model.trails import Trails


def drive(trails, seconds, speed=0.5, begin=0.0, robots=(1, 2)):
    """Drive along x from x = speed * begin on, 20 frames a second."""
    for frame in range(round(20 * seconds) + 1):
        t = begin + frame / 20
        trails.extend(t, list(robots), np.array([[speed * t] * len(robots), list(robots)]))
    return t


def lengths(trails):
    points = np.concatenate([chunk.points[0] for chunk in trails.chunks])
    return np.linalg.norm(points[:, 1] - points[:, 0], axis=1)


def test_a_trail_has_the_length_of_the_way_without_gaps():
    trails = Trails(length_s=100)
    drive(trails, 10)

    np.testing.assert_allclose(lengths(trails).sum(), 5.0, rtol=1e-5)
    segments = np.concatenate([chunk.points[0] for chunk in trails.chunks])
    np.testing.assert_allclose(segments[1:, 0], segments[:-1, 1], atol=1e-6)


def test_a_trail_is_bounded():
    trails = Trails(length_s=10)
    drive(trails, 100)

    assert 4.9 <= lengths(trails).sum() <= 7.0
    assert len(trails.chunks) <= 5


def test_only_the_newest_chunk_changes():
    trails = Trails()
    drive(trails, 5)
    before = [chunk.points.copy() for chunk in trails.chunks][:-1]
    drive(trails, 1, begin=5)

    for chunk, points in zip(trails.chunks, before, strict=False):
        np.testing.assert_array_equal(chunk.points, points)


def test_robots_that_stand_keep_their_trails():
    trails = Trails(length_s=5)
    end = drive(trails, 10)
    kept = lengths(trails).sum()
    for second in range(100):
        trails.extend(end + second, [1, 2], np.array([[0.5 * end] * 2, [1, 2]]))

    assert lengths(trails).sum() == kept


def test_a_jump_leaves_no_trail():
    trails = Trails()
    end = drive(trails, 2)
    trails.extend(end + 0.05, [1, 2], np.array([[0.5, 0.5], [1, 2]]), put={1, 2})
    trails.extend(end + 20, [1, 2], np.array([[0.9, 0.9], [1, 2]]))  # nobody has looked

    assert lengths(trails).max() < 0.2


def test_a_robot_that_comes_later_begins_its_trail_where_it_is():
    trails = Trails()
    end = drive(trails, 2, robots=(1,))
    trails.extend(end + 0.05, [1, 2], np.array([[1.0, 7.0], [1, 2]]))

    assert trails.chunks[-1].robots == (1, 2)
    assert not np.ptp(trails.chunks[-1].points[1, :, :, 0])


def test_a_page_that_is_opened_before_its_fleet_has_no_trails_yet():
    trails = Trails()
    trails.extend(0.0, [], np.empty((2, 0)))
    assert not trails.chunks

    trails.extend(0.1, [1], np.array([[1.0], [2.0]]))
    assert trails.chunks[-1].robots == (1,)
