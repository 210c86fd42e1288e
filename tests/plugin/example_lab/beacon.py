"""Beacons: a driver with a topic for each body, of a standard type."""

from setcmas_expe.mocap.messages import POSE_STAMPED
from setcmas_expe.mocap.sources import SILENCE, per_body

BEACON = per_body('/beacon/{name}/pose', POSE_STAMPED, SILENCE)
