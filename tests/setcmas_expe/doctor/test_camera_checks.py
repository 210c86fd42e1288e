"""The doctor's checks of cameras, on rendered pictures."""

from dataclasses import replace

import pytest

pytest.importorskip('cv2')

from camera_scene import camera, cv2, renderer, scene

from setcmas_expe.doctor.camera_checks import camera_findings
from setcmas_expe.doctor.findings import NOTE, OK, PROBLEM
from setcmas_expe.emulation.emulated_camera import PlacedTag
from setcmas_expe.lab.lab_options import LabOptions
from setcmas_expe.mocap.camera_file import write_cameras
from setcmas_simu.robots.arena import Arena

ROBOT = PlacedTag(1, 0.2, 0.1, 0.5)


def findings(folder, pictured, arena, **changes):
    (folder / 'pictures').mkdir()
    picture = renderer(pictured).picture([ROBOT], changes.pop('brightness', 1.0))
    for number in range(3):
        cv2.imwrite(str(folder / 'pictures' / f'{number}.png'), picture)
    file = scene(replace(camera(), source=str(folder / 'pictures')))
    write_cameras(file, folder / 'camera.yaml')
    lab = replace(LabOptions().chosen(), arena=arena)
    return {
        (one.what, one.level): f'{one.found} {one.advice}'
        for one in camera_findings(folder / 'camera.yaml', lab)
    }


def test_a_good_camera(tmp_path):
    found = findings(tmp_path, scene(), Arena(-0.6, 0.6, -0.3, 0.3))

    assert found['arena', OK].startswith('100 % of it is seen')
    assert found['floor tags', OK].startswith('4 seen, at most')
    assert found['accuracy', OK].endswith('px or more ')
    assert 'grey levels' in found['light', OK]
    assert (tmp_path / 'camera_left.png').is_file()


def test_what_to_change_is_said(tmp_path):
    found = findings(tmp_path, scene(camera(x=0.1)), Arena(-2, 2, -1, 1), brightness=0.25)

    assert 'hang the camera higher' in found['arena', PROBLEM]
    assert '--calibrate floor' in found['floor tags', PROBLEM]
    assert 'more light' in found['light', NOTE]
