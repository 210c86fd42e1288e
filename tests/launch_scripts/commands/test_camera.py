"""`setcmas camera` calibrates; the node behind it has tests of its own."""

import pytest
from processes import refuses, run_here

pytest.importorskip('cv2')

from camera_scene import FLOOR_TAGS, FOLDER, camera, scene
from msgspec.structs import replace

from setcmas_expe.mocap.camera_file import load_cameras, write_cameras

DISTANCES = {'501-502': 1.6, '501-503': 1.8868, '502-503': 1.0, '501-504': 1.0, '502-504': 1.8868}


@pytest.fixture
def folder(tmp_path):
    """A camera file whose lens is calibrated."""
    write(tmp_path)
    return tmp_path


def write(folder, **changes):
    begun = replace(camera(), source=str(FOLDER), pose=None)
    write_cameras(replace(scene(begun), **changes), folder / 'camera.yaml')


def test_the_floor_is_calibrated_from_distances(folder):
    write(folder, floor_tags={}, floor_distances=DISTANCES)
    result = run_here('camera', 'camera.yaml', '--calibrate', 'floor', cwd=folder)
    assert result.returncode == 0, result.stderr
    assert result.stdout.startswith('left: at x = 0.80 m, y = 0.80 m, 2.00 m above')

    content = load_cameras(folder / 'camera.yaml')
    assert content.floor_tags[503] == pytest.approx((1.6, 1.0), abs=1e-3)
    x, y, z = camera().pose.position
    first = FLOOR_TAGS[501]
    expected = (x - first[0], y - first[1], z)
    assert content.cameras[0].pose.position == pytest.approx(expected, abs=0.01)


def test_mistakes_are_one_line(folder):
    floor = ('camera', 'camera.yaml', '--calibrate', 'floor')
    write(folder, floor_tags={501: (0.0, 0.0)})
    refuses(*floor, message='the file has 1 floor tags; write the centres', cwd=folder)
    write(folder, cameras=())
    refuses(*floor, message='camera.yaml, line 1: there is no camera; begin with', cwd=folder)
    refuses('camera', 'no.yaml', message='no.yaml', cwd=folder)
    lens = ('camera', 'new.yaml', '--calibrate', 'lens', '--source', str(FOLDER))
    refuses(*lens, message='the board was seen in 0 places: 15 more views', cwd=folder)
    assert not (folder / 'new.yaml').exists()
    lens = ('camera', 'no/new.yaml', '--calibrate', 'lens', '--source', str(FOLDER))
    refuses(*lens, message="there is no folder 'no'", cwd=folder)
