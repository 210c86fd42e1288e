"""The camera node over DDS: poses from a folder and from a topic, a bumped camera."""

import sys

import numpy as np
import pytest

pytest.importorskip('rclpy')
from camera_scene import FOLDER, camera, cv2, pictures, scene, true_poses
from geometry_msgs.msg import PoseStamped
from msgspec.structs import replace
from processes import SETCMAS
from rclpy.time import Time
from sensor_msgs.msg import CompressedImage, Image

from setcmas_expe.mocap.camera_file import write_cameras
from setcmas_simu.ros import qos

NODE = [sys.executable, '-m', 'setcmas_expe.mocap.camera_node']
PICTURE = pictures()[0]


def camera_file(tmp_path, source):
    path = tmp_path / 'camera.yaml'
    write_cameras(scene(replace(camera(), source=str(source))), path)
    return str(path)


def test_poses_of_a_folder_of_pictures(start, peer, tmp_path):
    poses = peer.listen(PoseStamped, '/camera/tb3_7/pose', qos.SENSOR)
    node = start(*SETCMAS, 'camera', camera_file(tmp_path, FOLDER))
    peer.wait_for(lambda: len(poses) > 5)

    place = poses[-1].pose.position
    x, y, _ = min((one[7] for one in true_poses()), key=lambda one: abs(one[0] - place.x))
    assert (place.x, place.y, place.z) == pytest.approx((x, y, 0.2), abs=0.01)
    assert node.wait() == 0
    assert 'the pictures have ended' in node.output()


def test_poses_of_a_topic_until_the_camera_is_bumped(start, peer, tmp_path):
    node = start(*NODE, camera_file(tmp_path, '/image_raw'))
    poses = peer.listen(PoseStamped, '/camera/tb3_1/pose', qos.SENSOR)
    images = peer.publisher(Image, '/image_raw', qos=qos.SENSOR)
    bumped = np.roll(PICTURE, 20, axis=1)

    def send(picture):
        height, width = picture.shape
        image = Image(height=height, width=width, encoding='mono8', step=width)
        image.data = picture.tobytes()
        image.header.stamp = peer.node.get_clock().now().to_msg()
        images.publish(image)
        return 1e-9 * Time.from_msg(image.header.stamp).nanoseconds

    stamps = []

    def is_seen():
        stamps.append(send(PICTURE))
        return len(poses) > 3

    peer.wait_for(is_seen)
    exposed = 1e-9 * Time.from_msg(poses[-1].header.stamp).nanoseconds
    assert min(abs(exposed - stamp) for stamp in stamps) < 1e-6

    def is_reported():
        send(bumped)
        return 'camera left was moved: floor tag' in node.output()

    peer.wait_for(is_reported)
    seen = len(poses)
    for _ in range(5):
        send(PICTURE)
    peer.wait_for(lambda: 'no poses: camera left was moved' in node.output())
    assert len(poses) == seen
    assert node.end() == 0


def test_a_camera_without_pose_is_refused(start, tmp_path):
    path = tmp_path / 'camera.yaml'
    write_cameras(scene(replace(camera(), pose=None)), path)
    node = start(*NODE, str(path))

    assert node.wait() == 2
    assert "camera 'left' has no pose: run setcmas camera" in node.output()


@pytest.mark.parametrize('topic', ['/image_raw', '/image_raw/compressed'])
def test_a_floor_is_calibrated_by_a_topic(start, peer, tmp_path, topic):
    floor = start(*SETCMAS, 'camera', camera_file(tmp_path, topic), '--calibrate', 'floor')
    if topic == '/image_raw':
        height, width = PICTURE.shape
        image = Image(height=height, width=width, encoding='mono8', step=width)
        image.data = PICTURE.tobytes()
    else:
        image = CompressedImage(format='jpeg', data=cv2.imencode('.jpg', PICTURE)[1].tobytes())
    images = peer.publisher(type(image), topic, qos=qos.SENSOR)

    def has_enough():
        images.publish(image)
        return floor.popen.poll() is not None

    peer.wait_for(has_enough)
    assert floor.wait() == 0, floor.output()
    assert 'left: at x = ' in floor.output()


@pytest.mark.nightly
def test_a_silent_topic_is_an_error(start, tmp_path):
    floor = start(*SETCMAS, 'camera', camera_file(tmp_path, '/nothing'), '--calibrate', 'floor')

    assert floor.wait() == 2
    assert "no picture arrived on '/nothing'" in floor.output()
