"""The motion_capture_tracking driver (IMRCLab): one topic with all bodies that it sees.

It leaves out bodies that it tracks by itself and has lost, and passes on what the system says of
the others. A body that both know is in a message twice.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from setcmas_expe.mocap.messages import sample_of
from setcmas_expe.mocap.sample import Sample
from setcmas_expe.mocap.sources import NOT_A_NUMBER, REPEATED, SILENCE, MocapSource


def read_named_poses(message: Any) -> Iterator[tuple[str, Sample]]:
    """Read a motion_capture_tracking_interfaces/NamedPoseArray."""
    for body in message.poses:
        yield body.name, sample_of(message.header, body.pose.position, body.pose.orientation)


SOURCE = MocapSource(
    '/poses',
    'motion_capture_tracking_interfaces/msg/NamedPoseArray',
    read_named_poses,
    (SILENCE, REPEATED, NOT_A_NUMBER),
    driver='motion_capture_tracking 1.0.9',
)
