"""Emulated cameras: accuracy against the truth, and what each fault does to the poses."""

import math

import numpy as np
import pytest

pytest.importorskip('cv2')

from setcmas_expe.emulation import faults
from setcmas_expe.emulation.emulated_camera import EmulatedCamera, cameras_over
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.arena import Arena

SMALL = Arena(-2, 2, -1.5, 1.5)
POSES = np.array([[-1.0, 0.3, 1.2], [0.5, -0.4, 1.0], [0.3, 2.0, -2.5]])


def seen(camera, since=None, now=0.0, poses=POSES):
    """Return index, x, y, heading of the robots in a picture under faults."""
    before = camera.expose(poses, since or {}, now)
    assert before == []
    camera._pending.result()
    shown = camera.expose(poses, {(faults.STUCK, 0): now}, now)
    return {index: (x, y, heading) for _, index, x, y, heading in shown}


@pytest.fixture(scope='module')
def camera():
    return EmulatedCamera(SMALL, 3, 0)


@pytest.mark.parametrize('arena', [SMALL, Arena(-3, 3, -3, 3)])
def test_poses_are_accurate_everywhere(arena):
    own = EmulatedCamera(arena, 3, 0)
    places = POSES.copy()
    places[:2] = [[arena.xmin, 0.0, arena.xmax], [arena.ymax, 0.0, arena.ymin]]
    for index, (x, y, heading) in seen(own, poses=places).items():
        truth = places[:, index]
        assert math.hypot(x - truth[0], y - truth[1]) < 0.01
        assert abs(math.remainder(heading - truth[2], math.tau)) < 0.05


def test_an_arena_that_is_too_large_is_refused():
    with pytest.raises(SetcmasError, match='do not see the whole arena of 20 x 20 m'):
        cameras_over(Arena(-10, 10, -10, 10))


@pytest.mark.parametrize(
    ('kind', 'robots'),
    [
        (faults.GLARE, {0, 2}),
        (faults.COVERED, {0, 2}),
        (faults.TAG_SIZE, {0, 2}),
        (faults.FALLEN, {0, 2}),
        (faults.TWINS, {0}),
        (faults.SHRUNK, {0, 1, 2}),
    ],
)
def test_a_fault_hides_its_robot_alone(camera, kind, robots):
    now = camera._taken + 1.0 if math.isfinite(camera._taken) else 0.0
    found = seen(camera, {(kind, 1): now}, now)

    assert found.keys() == robots
    for index, (x, y, _) in found.items():
        assert math.hypot(x - POSES[0, index], y - POSES[1, index]) < 0.01


def test_a_bumped_camera_shows_no_robot_until_it_is_calibrated_again():
    own = EmulatedCamera(SMALL, 3, 0)
    assert seen(own).keys() == {0, 1, 2}
    for now in (0.1, 0.2, 0.3, 0.4):
        assert seen(own, {(faults.BUMPED, 0): 0.1}, now) == {}
    assert any('camera1 was moved' in line for line in own.news)
    assert seen(own, now=0.5).keys() == {0, 1, 2}


def test_frames_come_at_their_rate():
    own = EmulatedCamera(SMALL, 3, 0)
    seen(own)
    own.expose(POSES, {(faults.TEN_FRAMES, 0): 0.0}, 0.08)
    assert own._pending is None
    own.expose(POSES, {}, 0.08)
    assert own._pending
