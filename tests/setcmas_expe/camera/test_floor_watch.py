"""Floor tags in rendered pictures: a bumped camera, a moved tag, hidden tags."""

from dataclasses import replace

import pytest
from camera_scene import FLOOR_TAGS, camera, renderer, scene

from setcmas_expe.camera.floor_projection import FloorProjection
from setcmas_expe.camera.floor_watch import FloorWatch
from setcmas_expe.camera.tag_detection import TagDetector

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
