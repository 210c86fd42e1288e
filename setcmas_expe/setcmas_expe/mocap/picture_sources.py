"""Pictures with the time of their exposure: from a camera, a video or a series of files."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from pathlib import Path

from setcmas_expe.mocap.camera_poses import Shot
from setcmas_simu.errors import SetcmasError, needs

with needs('camera'):
    import cv2

Size = tuple[int, int]
"""Width and height in px."""

_OLDEST_STAMP_S = 1.0
_USUAL_HZ = 30.0


def pictures(source: str, size: Size | None) -> Iterator[Shot]:
    """Yield the pictures of a source as they come, until it ends; all have a size, if given.

    Raises:
        SetcmasError: It cannot be opened, fails, or sends pictures of another size.
    """
    is_camera = source.isdecimal() or source.startswith('/dev/')
    shots = _device(source, size or (1920, 1080)) if is_camera else _recording(source)
    for t, picture in shots:
        height, width = picture.shape[:2]
        if size and (width, height) != size:
            raise SetcmasError(
                f"'{source}' sends pictures of {width} x {height} px; its lens was calibrated "
                f'with {size[0]} x {size[1]} px'
            )
        yield t, picture


def _device(source: str, size: Size) -> Iterator[Shot]:
    """Yield the pictures of a camera of this machine, by Video4Linux.

    Their time is the kernel's, of the first data of the frame.
    """
    device = Path(f'/dev/video{source}' if source.isdecimal() else source)
    capture = cv2.VideoCapture()
    if not (device.exists() and capture.open(str(device), cv2.CAP_V4L2)):
        raise SetcmasError(
            f"camera '{source}' cannot be opened: is it connected, used by another program, "
            'and are you in the group video?'
        )
    # Most cameras give full pictures at full rate as JPEG only.
    capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*'MJPG'))
    capture.set(cv2.CAP_PROP_FRAME_WIDTH, size[0])
    capture.set(cv2.CAP_PROP_FRAME_HEIGHT, size[1])
    while True:
        arrived, picture = capture.read()
        if not arrived:
            raise SetcmasError(f"camera '{source}' sends no pictures: check its cable")
        age = time.monotonic() - 1e-3 * capture.get(cv2.CAP_PROP_POS_MSEC)
        yield time.time() - (age if 0 <= age < _OLDEST_STAMP_S else 0.0), picture


def _recording(source: str) -> Iterator[Shot]:
    """Yield the pictures of a video, or of a series such as 'pictures/%03d.png', at their rate."""
    video = cv2.VideoCapture(source) if Path(source).is_file() or '%' in source else None
    if not (video and video.isOpened()):
        raise SetcmasError(
            f"'{source}' is no source of pictures; it must be the number of a camera, such as 0, "
            'a video file, or a series of pictures, such as pictures/%03d.png'
        )
    period = 1.0 / (video.get(cv2.CAP_PROP_FPS) or _USUAL_HZ)
    shown = time.time()
    arrived, picture = video.read()
    if not arrived:
        raise SetcmasError(f"'{source}' has no pictures")
    while arrived:
        yield shown, picture
        time.sleep(max(0.0, shown + period - time.time()))
        shown = time.time()
        arrived, picture = video.read()


class NewestPicture:
    """Reads pictures in a thread, and keeps the newest."""

    def __init__(self, source: Iterator[Shot]) -> None:
        """Start to read."""
        self.ended = False
        self._newest: Shot | None = None
        self._error: Exception | None = None
        threading.Thread(target=self._read, args=(source,), daemon=True).start()

    def take(self) -> Shot | None:
        """Return the newest picture, once, else None; SetcmasError if the source failed."""
        if self._error:
            raise self._error
        shot, self._newest = self._newest, None
        return shot

    def _read(self, source: Iterator[Shot]) -> None:
        try:
            for self._newest in source:
                pass
        except Exception as error:  # raised where the pictures are taken
            self._error = error
        self.ended = True
