"""Pictures from folders, videos and messages; sources that are none."""

import time

import numpy as np
import pytest
from camera_scene import FOLDER, cv2

from setcmas_expe.mocap.picture_sources import FOLDER_HZ, NewestPicture, pictures
from setcmas_simu.errors import SetcmasError


def write_folder(folder, count):
    for number in range(count):
        cv2.imwrite(str(folder / f'{number}.png'), np.full((4, 4), number, np.uint8))
    return folder


def write_video(folder, count):
    path = folder / 'film.avi'
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*'MJPG'), 25.0, (64, 48))
    for number in range(count):
        writer.write(np.full((48, 64, 3), number, np.uint8))
    writer.release()
    return path


@pytest.mark.parametrize(('write', 'rate'), [(write_folder, FOLDER_HZ), (write_video, 25.0)])
def test_recorded_pictures_come_in_order_at_their_rate(tmp_path, write, rate):
    shots = list(pictures(str(write(tmp_path, 3)), None))

    assert [int(picture.max()) for _, picture in shots] == [0, 1, 2]
    assert np.diff([t for t, _ in shots]).min() >= 1 / rate


@pytest.mark.parametrize(
    ('source', 'reason'),
    [
        ('99', "camera '99' cannot be opened"),
        ('nowhere', "'nowhere' is no source of pictures"),
        ('.', 'has no pictures'),
    ],
)
def test_what_is_no_source_is_refused(source, reason, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SetcmasError, match=reason):
        next(pictures(source, None))


def test_pictures_of_another_size_are_refused():
    newest = NewestPicture(pictures(str(FOLDER), (640, 480)))

    while not newest.ended:
        time.sleep(0.01)

    with pytest.raises(SetcmasError, match='pictures of 960 x 600 px; its lens was calibrated'):
        newest.take()
