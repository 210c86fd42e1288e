"""Pictures in messages of ROS; test_camera_node has topics."""

from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip('rclpy')

from camera_scene import cv2

from setcmas_expe.mocap.picture_topics import decoded
from setcmas_simu.errors import SetcmasError

PICTURE = np.arange(2 * 3 * 3, dtype=np.uint8).reshape(2, 3, 3)


def message(encoding, picture, padding=0):
    rows = np.pad(picture.reshape(2, -1), ((0, 0), (0, padding)))
    size = {'height': 2, 'width': 3, 'step': rows.shape[1]}
    return SimpleNamespace(encoding=encoding, data=rows.tobytes(), **size)


@pytest.mark.parametrize('padding', [0, 5])
def test_images_are_decoded(padding):
    assert (decoded(message('bgr8', PICTURE, padding)) == PICTURE).all()
    assert (decoded(message('8UC3', PICTURE, padding)) == PICTURE).all()
    assert (decoded(message('rgb8', PICTURE[:, :, ::-1], padding)) == PICTURE).all()
    for encoding in ('mono8', '8UC1'):
        assert (decoded(message(encoding, PICTURE[:, :, 0], padding)) == PICTURE[:, :, 0]).all()
    with pytest.raises(SetcmasError, match="the encoding 'bayer'; it must be one of mono8"):
        decoded(message('bayer', PICTURE))


@pytest.mark.parametrize(('encoding', 'grey'), [('yuv422_yuy2', 0), ('yuv422', 1)])
def test_pixels_in_pairs_keep_their_brightness(encoding, grey):
    picture = np.full((2, 3, 2), 128, np.uint8)  # an odd width: the last pixel has no partner
    picture[:, :, grey] = [50, 100, 200]
    bright = decoded(message(encoding, picture)).astype(float)

    assert bright.shape == (2, 2, 3)
    np.testing.assert_allclose(
        bright, [[3 * [1.164 * (50 - 16)], 3 * [1.164 * (100 - 16)]]] * 2, atol=1
    )


def test_compressed_images_are_decoded():
    data = cv2.imencode('.png', PICTURE)[1].tobytes()
    assert (decoded(SimpleNamespace(format='png', data=data)) == PICTURE).all()
    with pytest.raises(SetcmasError, match='cannot be read: jpeg'):
        decoded(SimpleNamespace(format='jpeg', data=b'no picture'))
