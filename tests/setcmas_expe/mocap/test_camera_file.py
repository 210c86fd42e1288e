"""Camera files: written and read back, and mistakes with their lines."""

from dataclasses import replace

import pytest
from camera_scene import camera, scene

from setcmas_expe.mocap.camera_file import CameraFile, RobotTags, load_cameras, write_cameras
from setcmas_simu.errors import SetcmasError


@pytest.fixture
def path(tmp_path):
    path = tmp_path / 'camera.yaml'
    write_cameras(scene(camera(), camera(x=1.0, name='right')), path)
    return path


def test_a_file_is_read_back_as_it_was_written(path):
    assert load_cameras(path) == scene(camera(), camera(x=1.0, name='right'))


@pytest.mark.parametrize(
    ('old', 'new', 'message'),
    [
        ('size: 0.12', 'size: 120', 'tags.size is 120; it must be '),
        ('size: 0.12', 'sise: 0.12', "there is no key 'tags.sise'"),
        ('503', '600', "'600' is not a tag; it must be a number from 0 to 586"),
        ('[960, 600]', '[960]', 'a list of 2 numbers'),
        ('[960, 600]', '[960, 0]', 'lens.size[1] is 0'),
        ('name: right', 'name: left', "two cameras have the name 'left'"),
        (
            'position: [0.0, 0.3, 2.0]',
            'position: [0.0, 0.3, 0.1]',
            'but the tags are 0.2 m',
        ),
        ('0.0005', '.nan', 'lens.distortion[2] is nan'),
        ('height: 0.2', 'height: -1', 'tags.height is -1'),
    ],
)
def test_a_mistake_is_reported_with_its_line(path, old, new, message):
    text = path.read_text()
    assert old in text, text
    path.write_text(text.replace(old, new, 1))

    with pytest.raises(SetcmasError) as caught:
        load_cameras(path)

    assert message in str(caught.value)
    assert f'{path}, line ' in str(caught.value)
    assert '\n' not in str(caught.value)


def test_what_is_missing_is_named(tmp_path):
    path = tmp_path / 'camera.yaml'
    path.write_text('tags: {size: 0.12}\nfloor_tags: {}\ncameras: []\n')

    with pytest.raises(SetcmasError, match='line 1: tags has no height; add it'):
        load_cameras(path)


def test_a_file_may_wait_for_its_calibration(tmp_path):
    path = tmp_path / 'camera.yaml'
    begun = CameraFile(
        RobotTags(0.12, 0.2), (replace(camera(), pose=None),), {}, {(501, 502): 3.0}
    )
    write_cameras(begun, path)

    assert load_cameras(path) == begun
    path.write_text(path.read_text().replace('501-502', '501'))
    with pytest.raises(SetcmasError, match="line 13: '501' is not a pair of tags"):
        load_cameras(path)
