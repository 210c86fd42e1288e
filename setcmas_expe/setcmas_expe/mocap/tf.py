"""Transforms on /tf: any driver that sends them, and other nodes beside it.

Names are those of the frames: the child_frame_id. Robots may send transforms of their own there.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from setcmas_expe.mocap.messages import sample_of
from setcmas_expe.mocap.sample import Sample
from setcmas_expe.mocap.sources import REPEATED, SILENCE, MocapSource
from setcmas_simu.fleet.topics import TF


def read_transforms(message: Any) -> Iterator[tuple[str, Sample]]:
    """Read a tf2_msgs/TFMessage; parents are not looked at."""
    for one in message.transforms:
        transform = one.transform
        sample = sample_of(one.header, transform.translation, transform.rotation)
        yield one.child_frame_id, sample


SOURCE = MocapSource(
    TF,
    'tf2_msgs/msg/TFMessage',
    read_transforms,
    (SILENCE, REPEATED),
    shared=True,
    driver='any; tf2_msgs must be installed',
)
