"""`setcmas camera` calibrates; the node behind it has tests of its own."""

import pytest
from processes import refuses, run_here

pytest.importorskip('cv2')

from camera_scene import VIDEO, camera, scene
from msgspec.structs import replace

from setcmas_expe.mocap.camera_file import load_cameras, write_cameras


@pytest.fixture
def folder(tmp_path):
    """A camera file whose lens is calibrated."""
    write(tmp_path)
    return tmp_path


def write(folder, **changes):
    begun = replace(camera(), source=VIDEO, pose=None)
    write_cameras(replace(scene(begun), **changes), folder / 'camera.yaml')


def test_the_floor_is_calibrated(folder):
    result = run_here('camera', 'camera.yaml', '--calibrate', 'floor', cwd=folder)
    assert result.returncode == 0, result.stderr
    assert result.stdout.startswith('left: at x = 0.00 m, y = 0.30 m, 2.00 m above')

    content = load_cameras(folder / 'camera.yaml')
    assert content.cameras[0].pose.position == pytest.approx(camera().pose.position, abs=0.01)


def test_mistakes_are_one_line(folder):
    floor = ('camera', 'camera.yaml', '--calibrate', 'floor')
    write(folder, floor_tags={501: (0.0, 0.0)})
    refuses(*floor, message='the file has 1 floor tags; write the centres', cwd=folder)
    write(folder, cameras=())
    refuses(*floor, message='camera.yaml, line 1: there is no camera; begin with', cwd=folder)
    refuses('camera', 'no.yaml', message='no.yaml', cwd=folder)
    lens = ('camera', 'new.yaml', '--calibrate', 'lens', '--source', VIDEO)
    refuses(*lens, message='the board was seen in 0 places: 15 more views', cwd=folder)
    assert not (folder / 'new.yaml').exists()
    lens = ('camera', 'no/new.yaml', '--calibrate', 'lens', '--source', VIDEO)
    refuses(*lens, message="there is no folder 'no'", cwd=folder)
