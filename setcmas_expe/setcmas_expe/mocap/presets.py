"""Motion capture drivers with a topic per rigid body."""

from setcmas_expe.mocap.messages import ODOMETRY, POSE_STAMPED
from setcmas_expe.mocap.sources import HUGE, REPEATED, SILENCE, ZEROS, per_body

QUALISYS = per_body('/qualisys/{name}/odom', ODOMETRY, SILENCE)
VRPN = per_body('/vrpn_mocap/{name}/pose', POSE_STAMPED, SILENCE, REPEATED)
OPTITRACK = NATNET = per_body('/{name}/pose', POSE_STAMPED, SILENCE, REPEATED)
NOKOV = per_body('/{name}/pose', POSE_STAMPED, SILENCE, HUGE)
VICON = per_body('/vicon/{name}/{name}', POSE_STAMPED, ZEROS)
