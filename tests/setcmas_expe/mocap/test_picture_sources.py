"""Pictures from recordings; sources that are none."""

import time

import numpy as np
import pytest
from camera_scene import VIDEO, cv2

from setcmas_expe.mocap.picture_sources import NewestPicture, pictures
from setcmas_simu.errors import SetcmasError


def test_recorded_pictures_come_in_order_at_their_rate(tmp_path):
    path = str(tmp_path / 'film.avi')
    writer = cv2.VideoWriter(path, cv2.VideoWriter.fourcc(*'MJPG'), 25.0, (64, 48))
    for number in range(3):
        writer.write(np.full((48, 64, 3), number, np.uint8))
    writer.release()
    shots = list(pictures(path, None))

    assert [int(picture.max()) for _, picture in shots] == [0, 1, 2]
    assert np.diff([t for t, _ in shots]).min() >= 1 / 25.0


@pytest.mark.parametrize(
    ('source', 'reason'),
    [('99', "camera '99' cannot be opened"), ('nowhere', "'nowhere' is no source of pictures")],
)
def test_what_is_no_source_is_refused(source, reason):
    with pytest.raises(SetcmasError, match=reason):
        next(pictures(source, None))


def test_pictures_of_another_size_are_refused():
    newest = NewestPicture(pictures(VIDEO, (640, 480)))

    while not newest.ended:
        time.sleep(0.01)

    with pytest.raises(SetcmasError, match='pictures of 960 x 600 px; its lens was calibrated'):
        newest.take()
