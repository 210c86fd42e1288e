"""Motion capture drivers with a topic per rigid body."""

from dataclasses import replace

from setcmas_expe.mocap.messages import ODOMETRY, POSE_STAMPED
from setcmas_expe.mocap.sources import HUGE, REPEATED, SILENCE, ZEROS, per_body

QUALISYS = replace(
    per_body('/qualisys/{name}/odom', ODOMETRY, SILENCE),
    driver='motion_capture_system (KumarRobotics, KTH-SML), for ROS 1',
)
VRPN = replace(
    per_body('/vrpn_mocap/{name}/pose', POSE_STAMPED, SILENCE, REPEATED),
    driver='vrpn_mocap 1.1.0 and 1.2.0',
)
OPTITRACK = replace(
    per_body('/{name}/pose', POSE_STAMPED, SILENCE, REPEATED),
    driver='mocap_optitrack 1.1.0, topics by its mocap.yaml',
)
NATNET = replace(OPTITRACK, driver='natnet_ros2 (L2S-lab), commit 3e3f8d3')
NOKOV = replace(per_body('/{name}/pose', POSE_STAMPED, SILENCE, HUGE), driver='not verified')
VICON = replace(
    per_body('/vicon/{name}/{name}', POSE_STAMPED, ZEROS),
    driver='vicon_receiver 0.1.1 (ros2-vicon-receiver)',
)
