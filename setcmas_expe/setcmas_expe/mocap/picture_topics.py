"""Pictures of ROS topics."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from sensor_msgs.msg import CompressedImage, Image

from setcmas_expe.mocap.camera_poses import Picture, Shot
from setcmas_simu.errors import SetcmasError, needs
from setcmas_simu.ros import qos
from setcmas_simu.ros.polling import PolledTopic
from setcmas_simu.ros.process import FleetNode, ros_process

with needs('camera'):
    import cv2

_LOOK_S = 0.01
_PATIENCE_S = 10.0
_ENCODINGS: dict[str, tuple[int, int | None]] = {
    'mono8': (1, None),
    '8UC1': (1, None),
    'bgr8': (3, None),
    '8UC3': (3, None),
    'rgb8': (3, cv2.COLOR_RGB2BGR),
    'bgra8': (4, cv2.COLOR_BGRA2BGR),
    'rgba8': (4, cv2.COLOR_RGBA2BGR),
    'yuv422_yuy2': (2, cv2.COLOR_YUV2BGR_YUY2),
    'yuyv': (2, cv2.COLOR_YUV2BGR_YUY2),
    'yuv422': (2, cv2.COLOR_YUV2BGR_UYVY),
    'uyvy': (2, cv2.COLOR_YUV2BGR_UYVY),
}
"""Bytes of a pixel, and the conversion to blue, green, red."""


class PictureTopic:
    """Pictures of a topic: sensor_msgs/CompressedImage if its name ends so, else Image."""

    ended = False

    def __init__(self, node: FleetNode, name: str) -> None:
        self._messages: list[Any] = []
        kind = CompressedImage if name.endswith('/compressed') else Image
        take = self._messages.append
        self._topic = PolledTopic(node, kind, node.name_in_fleet(name), take, qos.SENSOR)

    def take(self) -> Shot | None:
        """Return the newest picture, once; its time is the stamp that its driver gave it."""
        self._topic.take()
        if not self._messages:
            return None
        message = self._messages[-1]
        self._messages.clear()
        stamp = message.header.stamp
        return stamp.sec + 1e-9 * stamp.nanosec, decoded(message)


def listen(name: str) -> Iterator[Shot]:
    """Yield the pictures of a topic, without a node; SetcmasError if none arrives for a while."""
    with ros_process() as process:
        topic = PictureTopic(FleetNode('camera_pictures'), name)
        since = time.monotonic()
        while not process.stopping:
            if shot := topic.take():
                yield shot
                since = time.monotonic()
            elif time.monotonic() - since > _PATIENCE_S:
                raise SetcmasError(f"no picture arrived on '{name}': check its camera")
            process.serve(_LOOK_S)
    raise KeyboardInterrupt


def decoded(message: Any) -> Picture:
    """Return the picture of a sensor_msgs/Image or CompressedImage, or raise SetcmasError."""
    data = np.frombuffer(message.data, np.uint8)
    if hasattr(message, 'format'):
        picture = cv2.imdecode(data, cv2.IMREAD_COLOR) if len(data) else None
        if picture is None:
            raise SetcmasError(f'compressed pictures cannot be read: {message.format}')
        return picture
    if message.encoding not in _ENCODINGS:
        must_be = f'it must be one of {", ".join(_ENCODINGS)}'
        raise SetcmasError(f"pictures have the encoding '{message.encoding}'; {must_be}")
    depth, conversion = _ENCODINGS[message.encoding]
    if len(data) != message.height * message.step or message.step < depth * message.width:
        raise SetcmasError(f'a picture of {message.height} rows has {len(data)} bytes')
    width = message.width - message.width % 2 if depth == 2 else message.width  # pixels in pairs
    rows = data.reshape(message.height, message.step)[:, : depth * width]
    picture = np.ascontiguousarray(rows.reshape(message.height, width, depth))
    if conversion is not None:
        return cv2.cvtColor(picture, conversion)
    return picture[:, :, 0] if depth == 1 else picture
