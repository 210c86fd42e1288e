"""Pictures with the time of their exposure: from a camera, a video or a folder."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from pathlib import Path

from setcmas_expe.mocap.camera_poses import Picture, Shot
from setcmas_simu.errors import SetcmasError, needs

with needs('camera'):
    import cv2

Size = tuple[int, int]
"""Width and height in px."""

FOLDER_HZ = 10.0
"""Pictures a second from a folder."""
_SUFFIXES = ('.png', '.jpg', '.jpeg', '.bmp')
_OLDEST_STAMP_S = 1.0


def pictures(source: str, size: Size | None) -> Iterator[Shot]:
    """Yield the pictures of a source as they come, until it ends; all have a size, if given.

    Raises:
        SetcmasError: It cannot be opened, fails, or sends pictures of another size.
    """
    for t, picture in _opened(source, size):
        height, width = picture.shape[:2]
        if size and (width, height) != size:
            raise SetcmasError(
                f"'{source}' sends pictures of {width} x {height} px; its lens was calibrated "
                f'with {size[0]} x {size[1]} px'
            )
        yield t, picture


def _opened(source: str, size: Size | None) -> Iterator[Shot]:
    if source.isdecimal() or source.startswith('/dev/'):
        return _device(source, size or (1920, 1080))
    if Path(source).exists():
        return _recording(Path(source))
    raise SetcmasError(
        f"'{source}' is no source of pictures; it must be the number of a camera, such as 0, a "
        'video file or a folder of pictures'
    )


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


def _recording(path: Path) -> Iterator[Shot]:
    """Yield the pictures of a video, or of a folder in the order of their names, at their rate."""
    rate, recorded = FOLDER_HZ, _folder(path)
    if not path.is_dir():
        video = cv2.VideoCapture(str(path))
        rate, recorded = video.get(cv2.CAP_PROP_FPS) or FOLDER_HZ, _frames(video)
    is_empty, shown = True, time.time()
    for picture in recorded:
        yield shown, picture
        is_empty = False
        time.sleep(max(0.0, shown + 1.0 / rate - time.time()))
        shown = time.time()
    if is_empty:
        raise SetcmasError(f"'{path}' has no pictures ({', '.join(_SUFFIXES)}, or a video)")


def _folder(path: Path) -> Iterator[Picture]:
    for one in sorted(path.iterdir()):
        if one.suffix.lower() in _SUFFIXES:
            picture = cv2.imread(str(one))
            if picture is None:
                raise SetcmasError(f"'{one}' is not a picture")
            yield picture


def _frames(video: cv2.VideoCapture) -> Iterator[Picture]:
    while (frame := video.read())[0]:
        yield frame[1]


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
