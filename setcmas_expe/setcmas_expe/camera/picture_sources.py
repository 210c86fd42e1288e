"""Pictures with the time of their exposure: from a camera, a video, a folder or a ROS topic."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Protocol

import numpy as np

from setcmas_expe.camera.camera_file import Camera
from setcmas_expe.camera.tag_detection import Shot
from setcmas_simu.errors import SetcmasError, needs

with needs('camera'):
    import cv2

FOLDER_HZ = 10.0
"""Pictures a second from a folder."""
_SUFFIXES = ('.png', '.jpg', '.jpeg', '.bmp')
_OLDEST_STAMP_S = 1.0


class PictureSource(Protocol):
    """Where pictures come from."""

    def read(self) -> Shot | None:
        """Wait for the next picture; None at the end.

        Raises:
            SetcmasError: There is none, and there should be.
        """


class Device:
    """A camera of this machine, by Video4Linux."""

    def __init__(self, source: str, size: tuple[int, int] | None) -> None:
        """Open a device by number or path, for pictures of a size in px."""
        self._source = source
        device = int(source) if source.isdecimal() else source
        self._capture = cv2.VideoCapture(device, cv2.CAP_V4L2)
        if not self._capture.isOpened():
            raise SetcmasError(
                f"camera '{source}' cannot be opened: is it connected, used by another program, "
                'and are you in the group video?'
            )
        # Most cameras give full pictures at full rate as JPEG only.
        self._capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*'MJPG'))
        for key, value in zip(
            (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT),
            size or (1920, 1080),
            strict=True,
        ):
            self._capture.set(key, value)

    def read(self) -> Shot | None:
        """Wait for the next picture; its time is the kernel's, of the first data of the frame."""
        arrived, picture = self._capture.read()
        if not arrived:
            raise SetcmasError(f"camera '{self._source}' sends no pictures: check its cable")
        age = time.monotonic() - 1e-3 * self._capture.get(cv2.CAP_PROP_POS_MSEC)
        return time.time() - (age if 0 <= age < _OLDEST_STAMP_S else 0.0), np.asarray(
            picture, np.uint8
        )


class Recording:
    """A video file, or a folder of pictures in the order of their names, at its own rate."""

    def __init__(self, path: Path) -> None:
        """Open it; it starts now."""
        self._begin = time.time()
        self._count = 0
        self._files: list[Path] = []
        self._period = 1 / FOLDER_HZ
        if path.is_dir():
            self._files = sorted(one for one in path.iterdir() if one.suffix.lower() in _SUFFIXES)
            found = bool(self._files)
        else:
            self._video = cv2.VideoCapture(str(path))
            found = self._video.isOpened()
            self._period = 1 / (self._video.get(cv2.CAP_PROP_FPS) or FOLDER_HZ)
        if not found:
            raise SetcmasError(f"'{path}' has no pictures ({', '.join(_SUFFIXES)}, or a video)")
        self._is_video = not self._files

    def read(self) -> Shot | None:
        """Wait until the next picture is due."""
        if self._is_video:
            arrived, picture = self._video.read()
        elif arrived := self._count < len(self._files):
            path = self._files[self._count]
            read = cv2.imread(str(path))
            if read is None:
                raise SetcmasError(f"'{path}' is not a picture")
            picture = read
        if not arrived:
            return None
        t = self._begin + self._count * self._period
        self._count += 1
        time.sleep(max(0.0, t - time.time()))
        return t, np.asarray(picture, np.uint8)


def open_source(
    source: str, size: tuple[int, int] | None, topic: Callable[[str], PictureSource] | None = None
) -> PictureSource:
    """Return where the pictures of a camera come from.

    Args:
        source: Number or path of a device, a video file, a folder, or a topic.
        size: Width and height in px.
        topic: Returns the source for the name of a topic; by default a node of its own listens.

    Raises:
        SetcmasError: It cannot be opened.
    """
    if source.isdecimal() or source.startswith('/dev/'):
        return Device(source, size)
    if Path(source).exists():
        return Recording(Path(source))
    if source.startswith('/') and topic:
        return topic(source)
    if source.startswith('/') and find_spec('rclpy'):
        # Imported late: other sources need no ROS.
        from setcmas_expe.camera.picture_topics import listened_topic

        return listened_topic(source)
    raise SetcmasError(
        f"'{source}' is no source of pictures; it must be the number of a camera, such as 0, a "
        'video file, a folder of pictures, or a topic, such as /camera/image_raw'
    )


class NewestPicture:
    """Reads a camera's pictures in a thread, and keeps the newest."""

    def __init__(self, camera: Camera, source: PictureSource) -> None:
        """Start to read."""
        self.camera = camera
        self.ended = False
        self._source = source
        self._newest: Shot | None = None
        self._error: SetcmasError | None = None
        threading.Thread(target=self._read, daemon=True).start()

    def take(self) -> Shot | None:
        """Return the newest picture, once; None if there is no new one.

        Raises:
            SetcmasError: The source failed, or its pictures have another size.
        """
        if self._error:
            raise self._error
        shot, self._newest = self._newest, None
        if shot:
            height, width = shot[1].shape[:2]
            if (width, height) != self.camera.lens.size:
                expected = ' x '.join(map(str, self.camera.lens.size))
                raise SetcmasError(
                    f"camera '{self.camera.name}' sends pictures of {width} x {height} px; its "
                    f'lens was calibrated with {expected} px'
                )
        return shot

    def _read(self) -> None:
        try:
            while shot := self._source.read():
                self._newest = shot
        except SetcmasError as error:
            self._error = error
        self.ended = True
