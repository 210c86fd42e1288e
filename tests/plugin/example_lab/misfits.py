"""Plugins of the wrong type."""

from setcmas_expe.mocap.sources import MocapSource

A_TEXT = 'brick'
NO_TOPIC = MocapSource('no topic', 'tf2_msgs/msg/TFMessage', iter)
