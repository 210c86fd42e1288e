"""A driver that publishes all bodies as transforms on /frames, with frames named after bodies."""

from setcmas_expe.mocap.sources import MocapSource, sample_of


def read_transforms(message):
    """Yield the name and the measurement of each body."""
    for one in message.transforms:
        transform = one.transform
        sample = sample_of(one.header, transform.translation, transform.rotation)
        yield one.child_frame_id, sample


FRAMES = MocapSource('/frames', 'tf2_msgs/msg/TFMessage', read_transforms)
