"""Two cameras that disagree, bumped cameras, moved and hidden floor tags, two equal tags."""

import math
from dataclasses import replace

import numpy as np
import pytest
from camera_scene import FLOOR_TAGS, camera, renderer, scene

from setcmas_expe.camera.camera_poses import OLDEST_S, CameraPoses, FloorWatch, FusedPoses
from setcmas_expe.camera.floor_projection import FloorProjection
from setcmas_expe.camera.picture_rendering import PlacedTag
from setcmas_expe.camera.tag_detection import TagDetector, TagPose

SPEED = 0.2
BIAS = 0.02
"""Distance in m between what the two cameras see."""


def edge(camera, x):
    """Return the distance in px from the edge; the cameras overlap from x = -0.5 to 0.5 m."""
    return 300 * (0.5 - x if camera == 'left' else x + 0.5)


def crossing(rates, end=math.inf, shift=0.0):
    """Return the fused positions of a robot on its way from left to right, 100 a second."""
    fused = FusedPoses()
    found = []
    last = dict.fromkeys(rates, -math.inf)
    for t in np.arange(0.0, 6.0, 0.01):
        for name, rate in rates.items():
            x = -0.6 + SPEED * (t - shift)
            if t - last[name] >= 1 / rate and edge(name, x) > 0 and (name == 'left' or t < end):
                last[name] = t
                y = BIAS if name == 'right' else 0.0
                fused.add(1, name, t - shift, TagPose(x, y, math.pi, edge(name, x)))
        pose = fused.pose(1, t)
        found.append((t, *(pose or (math.nan,) * 3)))
    return np.array(found)


@pytest.mark.parametrize('rates', [{'left': 30, 'right': 30}, {'left': 30, 'right': 11}])
def test_a_robot_crosses_the_seam_without_a_jump(rates):
    t, x, y, heading = crossing(rates, shift=0.03).T

    np.testing.assert_allclose(x, -0.6 + SPEED * t, atol=0.02)
    assert np.abs(np.diff(y)).max() < BIAS / 5
    assert y[10] == 0.0
    assert y[-1] == BIAS
    assert np.abs(np.cos(heading) + 1).max() < 1e-9


def test_a_camera_that_stops_moves_the_pose_gradually():
    t, _, y, _ = crossing({'left': 30, 'right': 30}, end=3.0).T

    assert y[t < 2.9].max() > 0.3 * BIAS
    assert np.abs(np.diff(y[t < 5])).max() < BIAS / 5
    assert y[np.searchsorted(t, 3.0 + OLDEST_S + 0.1)] == 0.0


def test_a_heading_turns_on_past_half_a_turn():
    fused = FusedPoses()
    for t, heading in ((0.0, math.pi - 0.01), (0.1, -math.pi + 0.01)):
        fused.add(1, 'left', t, TagPose(0.0, 0.0, heading, 200.0))

    assert fused.pose(1, 0.15)[2] == pytest.approx(-math.pi + 0.02)


def test_an_old_pose_is_not_used():
    fused = FusedPoses()
    fused.add(1, 'left', 1.0, TagPose(0.0, 0.0, 0.0, 200.0))
    fused.add(1, 'left', 0.5, TagPose(9.0, 0.0, 0.0, 200.0))

    assert fused.pose(1, 1.1) == (0.0, 0.0, 0.0)
    assert fused.pose(1, 1.0 + OLDEST_S) is None
    assert fused.pose(2, 1.0) is None


FILE = scene()


def fault(pictured, seconds=0.4):
    """Return the fault of the calibrated camera after pictures of another scene."""
    watch = FloorWatch(FloorProjection(FILE.cameras[0]), FLOOR_TAGS, 0.0)
    corners, _ = TagDetector().corners(renderer(pictured).picture([]))
    for step in range(round(30 * seconds)):
        watch.look(step / 30, corners)
    return watch.fault


def test_a_camera_in_its_place_has_no_fault():
    assert fault(FILE, 2.0) == ''


@pytest.mark.parametrize('bumped', [camera(x=0.05), camera(tilt=0.19)])
def test_a_bumped_camera_is_a_fault(bumped):
    assert fault(scene(bumped)).startswith('camera left was moved: floor tag 50')
    assert fault(scene(bumped), 0.1) == ''  # a single picture proves nothing


def test_a_floor_tag_that_was_moved_is_named():
    moved = replace(FILE, floor_tags=FLOOR_TAGS | {502: (0.8, -0.4)})

    assert fault(moved) == 'floor tag 502 is 100 mm from its place for camera left; put it back'


def test_a_camera_without_floor_tags_is_a_fault():
    covered = replace(FILE, floor_tags={})

    assert fault(covered, 0.9) == ''
    assert fault(covered, 1.2).startswith('camera left sees no floor tag')


def test_robots_are_found_unless_a_camera_was_bumped():
    placed = [PlacedTag(1, -0.3, 0.1, 0.5), PlacedTag(2, 0.4, 0.0, 2.0)]
    poses = CameraPoses(FILE, 2)
    found = poses.look('left', 0.0, renderer(FILE).picture(placed))

    assert found[1] == pytest.approx((-0.3, 0.1, 0.5), abs=0.02)
    assert found[2] == pytest.approx((0.4, 0.0, 2.0), abs=0.02)

    bumped = renderer(scene(camera(x=0.05))).picture(placed)
    assert poses.look('left', 0.1, bumped) == {}  # at once, before the fault is certain
    assert poses.fault == ''
    assert poses.look('left', 0.2, renderer(FILE).picture(placed)).keys() == {1, 2}
    for t in (0.3, 0.4, 0.5):
        assert poses.look('left', t, bumped) == {}
    assert 'was moved' in poses.fault
    assert poses.look('left', 0.6, renderer(FILE).picture(placed)) == {}


def test_two_equal_tags_are_no_robot():
    twins = [PlacedTag(1, -0.3, 0.1, 0.5), PlacedTag(1, 0.4, 0.0, 2.0)]
    poses = CameraPoses(FILE, 2)

    assert poses.look('left', 0.0, renderer(FILE).picture(twins)) == {}
    assert poses.reasons == {1: 'two tags have its number; each robot needs its own'}


def test_equal_tags_in_two_cameras_are_no_robot():
    file = replace(FILE, cameras=(camera(), replace(camera(), name='right')))
    poses = CameraPoses(file, 1)
    first, second = PlacedTag(1, -0.3, 0.1, 0.5), PlacedTag(1, 0.4, 0.0, 2.0)

    assert poses.look('left', 0.0, renderer(FILE).picture([first])).keys() == {1}
    assert poses.look('right', 0.01, renderer(FILE).picture([second])) == {}
    assert poses.reasons[1].startswith('two cameras')
