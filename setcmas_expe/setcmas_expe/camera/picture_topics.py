"""Pictures of ROS topics."""

from __future__ import annotations

import atexit
import contextlib
import functools
import time
from typing import Any

import numpy as np
from sensor_msgs.msg import CompressedImage, Image

from setcmas_expe.camera.tag_detection import Picture, Shot
from setcmas_simu.errors import SetcmasError, needs
from setcmas_simu.ros import qos
from setcmas_simu.ros.polling import PolledTopic
from setcmas_simu.ros.process import FleetNode, RosProcess, ros_process

with needs('camera'):
    import cv2

_LOOK_S = 0.002
_PATIENCE_S = 10.0


class PictureTopic:
    """Pictures of a topic: sensor_msgs/CompressedImage if its name ends so, else Image."""

    def __init__(self, node: FleetNode, name: str, process: RosProcess | None = None) -> None:
        """Listen; with a process, until it stops or no picture arrives for a while."""
        self._name = name
        self._process = process
        self._messages: list[Image | CompressedImage] = []
        kind = CompressedImage if name.endswith('/compressed') else Image
        self._topic = PolledTopic(node, kind, name, self._messages.append, qos.SENSOR)

    def read(self) -> Shot | None:
        """Wait for the next picture; its time is the stamp that the camera's driver gave it."""
        since = time.monotonic()
        while not self._messages:
            time.sleep(_LOOK_S)
            self._topic.take()
            if self._process and self._process.stopping:
                raise KeyboardInterrupt
            if self._process and time.monotonic() - since > _PATIENCE_S:
                raise SetcmasError(f"no picture arrived on '{self._name}': check its camera")
        message = self._messages[-1]
        self._messages.clear()
        stamp = message.header.stamp
        return stamp.sec + 1e-9 * stamp.nanosec, decoded(message)


@functools.cache
def _listening() -> tuple[RosProcess, FleetNode]:
    """Return the node that listens to all topics of this process, until the process ends."""
    stack = contextlib.ExitStack()
    atexit.register(stack.close)
    process = stack.enter_context(ros_process())
    node = FleetNode('camera_pictures')
    process.add(node)
    return process, node


def listened_topic(name: str) -> PictureTopic:
    """Return the pictures of a topic, for a program that is no node."""
    process, node = _listening()
    return PictureTopic(node, node.name_in_fleet(name), process)


def decoded(message: Any) -> Picture:
    """Return the picture of a sensor_msgs/Image or CompressedImage.

    Raises:
        SetcmasError: Its encoding is not known.
    """
    data = np.frombuffer(message.data, np.uint8)
    if hasattr(message, 'format'):
        picture = cv2.imdecode(data, cv2.IMREAD_COLOR)
        if picture is None:
            raise SetcmasError(f'compressed pictures cannot be read: {message.format}')
        return np.asarray(picture, np.uint8)
    depths = {'mono8': 1, 'bgr8': 3, 'rgb8': 3, 'bgra8': 4, 'rgba8': 4}
    depth = depths.get(message.encoding)
    if depth is None:
        raise SetcmasError(
            f"pictures have the encoding '{message.encoding}'; it must be one of "
            f'{", ".join(depths)}'
        )
    rows = data.reshape(message.height, message.step)[:, : depth * message.width]
    picture = rows.reshape(message.height, message.width, depth)
    return picture[:, :, 0] if depth == 1 else np.ascontiguousarray(picture[:, :, :3])
