"""The camera node over DDS: poses from a folder, and a camera without a pose."""

import sys

import pytest

pytest.importorskip('rclpy')
from camera_scene import FOLDER, camera, scene, true_poses
from geometry_msgs.msg import PoseStamped
from msgspec.structs import replace
from processes import SETCMAS

from setcmas_expe.mocap.camera_file import write_cameras
from setcmas_simu.ros import qos

NODE = [sys.executable, '-m', 'setcmas_expe.mocap.camera_node']


def camera_file(tmp_path, source):
    path = tmp_path / 'camera.yaml'
    write_cameras(scene(replace(camera(), source=str(source))), path)
    return str(path)


def test_poses_of_a_folder_of_pictures(start, peer, tmp_path):
    for i in range(100):  # 4 s: the listener finds the node only when it begins
        (tmp_path / f'{i:02}.jpg').symlink_to(FOLDER / f'{i % 10:02}.jpg')
    poses = peer.listen(PoseStamped, '/camera/tb3_7/pose', qos.SENSOR)
    node = start(*SETCMAS, 'camera', camera_file(tmp_path, tmp_path / '%02d.jpg'))
    peer.wait_for(lambda: len(poses) > 5)

    place = poses[-1].pose.position
    x, y, _ = min((one[7] for one in true_poses()), key=lambda one: abs(one[0] - place.x))
    assert (place.x, place.y, place.z) == pytest.approx((x, y, 0.2), abs=0.01)
    assert node.wait() == 0
    assert 'the pictures have ended' in node.output()


def test_a_camera_without_pose_is_refused(start, tmp_path):
    path = tmp_path / 'camera.yaml'
    write_cameras(scene(replace(camera(), pose=None)), path)
    node = start(*NODE, str(path))

    assert node.wait() == 2
    assert "camera 'left' has no pose: run setcmas camera" in node.output()
