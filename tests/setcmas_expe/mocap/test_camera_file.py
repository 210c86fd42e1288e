"""Camera files: written and read back, and mistakes with their lines."""

import pytest
from camera_scene import camera, scene
from msgspec.structs import replace

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
        ('size: 0.12', 'size: 120', 'tags.size: expected `float` <= 2.0'),
        ('size: 0.12', 'sise: 0.12', 'tags: object contains unknown field `sise`'),
        ('[960, 600]', '[960, 0]', 'lens.size[1]: expected `int` >= 1'),
        ('name: right', 'name: left', "two cameras have the name 'left'"),
        (
            'position: [0.0, 0.3, 2.0]',
            'position: [0.0, 0.3, 0.1]',
            'but the tags are 0.2 m',
        ),
        ('0.0005', '.nan', 'lens.distortion[2]: expected `float`'),
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

    with pytest.raises(SetcmasError, match='line 1: tags: object missing required field `height`'):
        load_cameras(path)


def test_a_file_may_wait_for_its_calibration(tmp_path):
    path = tmp_path / 'camera.yaml'
    begun = CameraFile(RobotTags(0.12, 0.2), (replace(camera(), pose=None),))
    write_cameras(begun, path)

    assert load_cameras(path) == begun
