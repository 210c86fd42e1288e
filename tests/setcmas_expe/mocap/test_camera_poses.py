"""Tags in a recorded video; several cameras; bumped cameras, hidden floor tags."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from camera_scene import (
    FLOOR_TAGS,
    camera,
    cv2,
    pictures,
    scene,
    seen_at,
    true_poses,
    with_copy,
)

from setcmas_expe.mocap.camera_file import RobotTags
from setcmas_expe.mocap.camera_poses import (
    LOST_AFTER_S,
    CameraPoses,
    FloorWatch,
    TagDetector,
    tag_family,
    tag_pose,
)
from setcmas_simu.errors import SetcmasError

FILE = scene()
PICTURE = pictures()[0]
TRUTH = true_poses()[0]


TAG_MOVED = 'camera left or floor tag 502 was moved: the tag is 100 mm from its place; put it'


@pytest.mark.parametrize(
    ('watched', 'floor_tags', 'seconds', 'fault'),
    [
        (camera(), FLOOR_TAGS, 2.0, ''),
        (camera(x=0.05), FLOOR_TAGS, 0.1, ''),  # a single picture proves nothing
        (camera(x=0.05), FLOOR_TAGS, 0.4, 'camera left or floor tag 50'),
        (camera(tilt=0.19), FLOOR_TAGS, 0.4, 'camera left or floor tag 50'),
        (camera(), FLOOR_TAGS | {502: (0.8, -0.4)}, 0.4, TAG_MOVED),
    ],
)
def test_what_was_moved_is_named(watched, floor_tags, seconds, fault):
    watch = FloorWatch(watched, floor_tags)
    corners, _ = TagDetector().corners(PICTURE)
    for step in range(round(30 * seconds)):
        watch.look(step / 30, corners)

    assert watch.fault.startswith(fault)
    assert bool(watch.fault) == bool(fault)


def test_poses_return_with_the_floor_tags():
    dark = (PICTURE // 20).astype(np.uint8)
    poses = CameraPoses(FILE, 7)
    for t, picture, robots in ((0.0, PICTURE, set(TRUTH)), (0.1, dark, set()), (0.9, dark, set())):
        assert poses.look('left', t, picture).keys() == robots
    assert poses.fault == ''
    poses.look('left', 1.2, dark)
    assert poses.fault.startswith('camera left sees no floor tag')
    assert poses.look('left', 1.3, PICTURE).keys() == set(TRUTH)
    assert poses.fault == ''


def test_robots_are_found_unless_a_camera_was_bumped():
    poses = CameraPoses(FILE, 7)
    bumped = np.roll(PICTURE, 20, axis=1)

    assert poses.look('left', 0.0, PICTURE).keys() == set(TRUTH)
    assert poses.look('left', 0.1, bumped) == {}  # at once, before the fault is certain
    assert poses.fault == ''
    assert poses.look('left', 0.2, PICTURE).keys() == set(TRUTH)
    for t in (0.3, 0.4, 0.5):
        assert poses.look('left', t, bumped) == {}
    assert 'was moved' in poses.fault
    assert poses.look('left', 0.6, PICTURE) == {}


def test_two_equal_tags_are_no_robot():
    twins = with_copy(PICTURE, 1, 0.2, -0.35)
    poses = CameraPoses(FILE, 7)

    assert 1 not in poses.look('left', 0.0, twins)
    assert poses.reasons['left'] == {1: 'two tags have its number; each robot needs its own'}
    assert 1 in poses.look('left', 0.1, PICTURE)
    assert poses.reasons['left'] == {}


def test_a_robot_is_seen_by_one_camera_until_that_one_loses_it():
    poses = CameraPoses(scene(camera(), camera(name='right')), 7)
    assert poses.look('left', 0.0, PICTURE).keys() == set(TRUTH)
    assert poses.look('right', 0.2, PICTURE) == {}  # 5 pictures/s
    assert poses.look('left', 0.25, PICTURE).keys() == set(TRUTH)

    assert poses.look('right', 0.26 + LOST_AFTER_S, PICTURE).keys() == set(TRUTH)
    assert poses.look('left', 0.27 + LOST_AFTER_S, PICTURE) == {}


@pytest.mark.parametrize('grey', [255, 140])
def test_a_robot_whose_tag_is_covered_has_no_pose(grey):
    middle = seen_at(camera(), np.array([[*TRUTH[3][:2], 0.2]]))[0].round().astype(int).tolist()
    picture = cv2.circle(PICTURE.copy(), middle, 20, grey, cv2.FILLED)

    assert CameraPoses(FILE, 7).look('left', 0.0, picture).keys() == TRUTH.keys() - {3}


def test_poses_are_those_of_the_robots_in_the_video():
    poses = CameraPoses(FILE, 7)
    distances, turns = [], []
    for number, (picture, truth) in enumerate(zip(pictures(), true_poses(), strict=True)):
        found = poses.look('left', number / 15, picture)
        assert found.keys() == truth.keys()
        for robot, (x, y, heading) in found.items():
            distances.append(math.dist((x, y), truth[robot][:2]))
            turns.append(abs(math.remainder(heading - truth[robot][2], math.tau)))

    assert len(distances) == 60
    assert max(distances) < 0.003
    assert max(turns) < math.radians(1.0)


def test_an_opencv_that_turns_the_tags_is_refused(monkeypatch):
    quarters = tag_family().bytesList.reshape(-1, 4, 5)
    turned = SimpleNamespace(bytesList=np.roll(quarters, 2, axis=1))
    monkeypatch.setattr(cv2.aruco, 'getPredefinedDictionary', lambda _: turned)

    with pytest.raises(SetcmasError, match='turns AprilTags by 180 degrees'):
        TagDetector()


SQUARE = 0.06 * np.array([[1.0, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0]])
TILTED = SQUARE @ np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]])
NO_SQUARE = 'it is not a square; it must be flat, level and not covered'


@pytest.mark.parametrize(
    ('tags', 'corners', 'reason'),
    [
        (RobotTags(0.12, 0.35), SQUARE, 'it must be 120 mm at 0.35 m above the floor'),
        (RobotTags(0.14, 0.2), SQUARE, 'it must be 140 mm at 0.2 m above the floor'),
        (FILE.tags, TILTED, 'its side measures'),
        (FILE.tags, SQUARE * [1.1, 0.9, 1], NO_SQUARE),
    ],
)
def test_a_tag_that_is_not_as_the_file_says_is_refused(tags, corners, reason):
    pixels = seen_at(camera(), corners + np.array([0, 0, FILE.tags.height]))

    assert reason in tag_pose(camera(), tags, pixels)
