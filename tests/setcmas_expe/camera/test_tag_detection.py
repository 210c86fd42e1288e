"""Tags in rendered pictures: poses against the truth, and tags that have no pose."""

import math
from dataclasses import replace

import numpy as np
import pytest
from camera_scene import camera, renderer, scene

from setcmas_expe.camera.camera_file import RobotTags
from setcmas_expe.camera.floor_projection import FloorProjection, expected_accuracy
from setcmas_expe.camera.picture_rendering import PictureQuality, PlacedTag
from setcmas_expe.camera.tag_detection import TagDetector, tag_poses


def errors(file, placed):
    """Return position errors in m and heading errors in degrees, shape (N,) each."""
    corners, _ = TagDetector().corners(renderer(file).picture(placed))
    projection = FloorProjection(file.cameras[0])
    poses, reasons = tag_poses(projection, file.tags, corners, len(placed))
    assert sorted(poses) == [tag.number for tag in placed], reasons
    found = [(poses[tag.number], tag) for tag in placed]
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
    projection = FloorProjection(file.cameras[0])
    expected = expected_accuracy(projection, file.tags, 0.6, 0.3)
    camera_pictures = renderer(file, quality=PictureQuality(noise=6.0))
    tag = PlacedTag(1, 0.6, 0.3, 0.4)
    found = []
    for _ in range(12):
        corners, _ = TagDetector().corners(camera_pictures.picture([tag]))
        found.append(tag_poses(projection, file.tags, corners, 1)[0][1])
    position = math.sqrt(np.mean([(one.x - tag.x) ** 2 + (one.y - tag.y) ** 2 for one in found]))
    heading = math.sqrt(np.mean([(one.heading - tag.heading) ** 2 for one in found]))

    assert position < 3 * expected.position
    assert heading < 3 * expected.heading
    assert expected_accuracy(projection, file.tags, 3.0, 0.0) is None


def test_a_wrong_calibration_costs_the_expected_accuracy():
    file = scene()
    sure = expected_accuracy(FloorProjection(file.cameras[0]), file.tags, 0.0, 0.0)
    unsure = replace(camera(), pose=replace(camera().pose, error=0.02))

    assert sure.position < 0.002
    unsure = expected_accuracy(FloorProjection(unsure), file.tags, 0.0, 0.0)
    assert unsure.position == pytest.approx(0.02, rel=0.05)


def test_two_equal_tags_have_no_pose():
    twins = [PlacedTag(1, -0.3, 0.0, 0.0), PlacedTag(1, 0.3, 0.0, 0.0)]

    corners, twice = TagDetector().corners(renderer(scene()).picture(twins))

    assert twice == {1}
    assert 1 not in corners


@pytest.mark.parametrize('tags', [RobotTags(0.12, 0.0), RobotTags(0.10, 0.2)])
def test_a_tag_of_another_size_or_height_is_refused(tags):
    file = scene()
    picture = renderer(replace(file, tags=tags)).picture([PlacedTag(1, 0.0, 0.0, 0.0)])
    corners, _ = TagDetector().corners(picture)

    poses, reasons = tag_poses(FloorProjection(file.cameras[0]), file.tags, corners, 1)

    assert poses == {}
    assert 'must be 120 mm at 0.2 m above the floor' in reasons[1]


def refusal(points):
    """Return why a tag has no pose whose corners are at points x, y, z in m from its centre."""
    file = scene()
    projection = FloorProjection(file.cameras[0])
    corners = projection.pixels(points + np.array([0, 0, file.tags.height]))
    _, reasons = tag_poses(projection, file.tags, {1: corners}, 1)
    return reasons[1]


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

    _, reasons = tag_poses(FloorProjection(file.cameras[0]), file.tags, {1: corners}, 1)

    assert reasons == {1: 'the camera does not look down on it'}
