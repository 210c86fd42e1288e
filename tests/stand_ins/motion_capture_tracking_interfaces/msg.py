"""Messages of motion_capture_tracking 1.0.9."""

from stand_in import message_class

_NAMED_POSE = 'motion_capture_tracking_interfaces/msg/NamedPose'
_NAMED_POSE_ARRAY = 'motion_capture_tracking_interfaces/msg/NamedPoseArray'

NamedPoseArray = message_class(
    _NAMED_POSE_ARRAY,
    {
        _NAMED_POSE: 'string name\ngeometry_msgs/Pose pose',
        _NAMED_POSE_ARRAY: f'std_msgs/Header header\n{_NAMED_POSE}[] poses',
    },
)
