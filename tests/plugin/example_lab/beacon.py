"""Beacons: a driver with a topic per body, of a standard type."""

from setcmas_expe.mocap.sources import POSE_STAMPED, per_body

BEACON = per_body('/beacon/{name}/pose', POSE_STAMPED)
