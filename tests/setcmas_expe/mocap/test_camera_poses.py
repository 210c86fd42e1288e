"""Tags in rendered pictures; two cameras that disagree; bumped cameras, hidden floor tags."""

import math
from dataclasses import replace

import numpy as np
import pytest
from camera_scene import FLOOR_TAGS, camera, renderer, scene

from setcmas_expe.emulation.emulated_camera import PlacedTag
from setcmas_expe.mocap.camera_file import RobotTags
from setcmas_expe.mocap.camera_poses import (
    OLDEST_S,
    CameraPoses,
    FloorWatch,
    FusedPoses,
    TagDetector,
    TagPose,
    tag_pose,
)

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
    watch = FloorWatch(FILE.cameras[0], FLOOR_TAGS)
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


def test_poses_return_with_the_floor_tags():
    robot = [PlacedTag(1, -0.3, 0.1, 0.5)]
    light, dark = (renderer(FILE).picture(robot, brightness) for brightness in (1.0, 0.05))
    poses = CameraPoses(FILE, 1)
    for t, picture, robots in ((0.0, light, {1}), (0.1, dark, set()), (1.2, dark, set())):
        assert poses.look('left', t, picture).keys() == robots
    assert poses.fault.startswith('camera left sees no floor tag')
    assert poses.look('left', 1.3, light).keys() == {1}
    assert poses.fault == ''


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
    assert poses.news() == ['robot 1: two tags have its number; each robot needs its own']


def test_a_reason_is_reported_once_until_it_was_gone_for_seconds():
    poses = CameraPoses(FILE, 2)
    twins = [PlacedTag(1, -0.3, 0.1, 0.5), PlacedTag(1, 0.4, 0.0, 2.0)]
    pictures = {True: renderer(FILE).picture(twins), False: renderer(FILE).picture(twins[:1])}
    reported = []
    for t, is_wrong in ((0.0, True), (0.1, True), (0.2, False), (0.3, True), (9.0, True)):
        poses.look('left', t, pictures[is_wrong])
        reported.append(len(poses.news()))

    assert reported == [1, 0, 0, 0, 1]


def test_equal_tags_in_two_cameras_are_no_robot():
    file = replace(FILE, cameras=(camera(), replace(camera(), name='right')))
    poses = CameraPoses(file, 1)
    first, second = PlacedTag(1, -0.3, 0.1, 0.5), PlacedTag(1, 0.4, 0.0, 2.0)

    assert poses.look('left', 0.0, renderer(FILE).picture([first])).keys() == {1}
    assert poses.look('right', 0.01, renderer(FILE).picture([second])) == {}
    assert poses.reasons['right'][1].startswith('two cameras')


def errors(file, placed):
    """Return position errors in m and heading errors in degrees, shape (N,) each."""
    corners, _ = TagDetector().corners(renderer(file).picture(placed))
    assert sorted(corners.keys() - FLOOR_TAGS.keys()) == [tag.number for tag in placed]
    found = [(tag_pose(file.cameras[0], file.tags, corners[tag.number]), tag) for tag in placed]
    position = [math.hypot(pose.x - tag.x, pose.y - tag.y) for pose, tag in found]
    heading = [math.remainder(pose.heading - tag.heading, math.tau) for pose, tag in found]
    return np.array(position), np.degrees(np.abs(heading))


def fleet(speed=0.0):
    places = [(-0.7, -0.25), (0.0, 0.0), (0.6, 0.3), (-0.5, 0.35), (0.5, -0.3)]
    headings = (-3.0, -1.2, 0.1, 1.5, 2.9)
    return [
        PlacedTag(
            i + 1, x, y, heading, speed * math.cos(heading), speed * math.sin(heading), speed
        )
        for i, ((x, y), heading) in enumerate(zip(places, headings, strict=True))
    ]


@pytest.mark.parametrize('speed', [0.0, 0.2])
def test_poses_are_those_of_the_tags(speed):
    position, heading = errors(scene(), fleet(speed))

    assert position.max() < 0.003
    assert heading.max() < 1.0


def test_the_expected_accuracy_is_that_of_many_pictures():
    file = scene()
    expected = file.cameras[0].accuracy(file.tags, 0.6, 0.3)
    camera_pictures = renderer(file, noise=6.0)
    tag = PlacedTag(1, 0.6, 0.3, 0.4)
    found = []
    for _ in range(12):
        corners, _ = TagDetector().corners(camera_pictures.picture([tag]))
        found.append(tag_pose(file.cameras[0], file.tags, corners[1]))
    position = math.sqrt(np.mean([(one.x - tag.x) ** 2 + (one.y - tag.y) ** 2 for one in found]))
    heading = math.sqrt(np.mean([(one.heading - tag.heading) ** 2 for one in found]))

    assert position < 3 * expected.position
    assert heading < 3 * expected.heading
    assert file.cameras[0].accuracy(file.tags, 3.0, 0.0) is None


def test_a_wrong_calibration_costs_the_expected_accuracy():
    file = scene()
    sure = file.cameras[0].accuracy(file.tags, 0.0, 0.0)
    unsure = replace(camera(), pose=replace(camera().pose, error=0.02))

    assert sure.position < 0.002
    assert unsure.accuracy(file.tags, 0.0, 0.0).position == pytest.approx(0.02, rel=0.05)


@pytest.mark.parametrize('tags', [RobotTags(0.12, 0.0), RobotTags(0.10, 0.2)])
def test_a_tag_of_another_size_or_height_is_refused(tags):
    file = scene()
    picture = renderer(replace(file, tags=tags)).picture([PlacedTag(1, 0.0, 0.0, 0.0)])
    corners, _ = TagDetector().corners(picture)

    assert 'must be 120 mm at 0.2 m above the floor' in tag_pose(
        file.cameras[0], file.tags, corners[1]
    )


def refusal(points):
    """Return why a tag has no pose whose corners are at points x, y, z in m from its centre."""
    file = scene()
    corners = file.cameras[0].pixels(points + np.array([0, 0, file.tags.height]))
    return tag_pose(file.cameras[0], file.tags, corners)


SQUARE = 0.06 * np.array([[1.0, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0]])


def test_a_tilted_tag_is_refused():
    assert 'its side measures' in refusal(
        SQUARE @ np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]])
    )


def test_a_tag_whose_corners_are_no_square_is_refused():
    bent = SQUARE * [1.1, 0.9, 1]

    assert refusal(bent) == 'it is not a square; it must be flat, level and not covered'


def test_a_camera_that_looks_up_has_no_pose():
    file = scene(camera(tilt=math.pi))
    corners = np.array([[10.0, 10], [50, 10], [50, 50], [10, 50]])

    reason = tag_pose(file.cameras[0], file.tags, corners)
    assert reason == 'the camera does not look down on it'
