"""Messages of mocap4r2 on Jazzy."""

from stand_in import message_class

_MARKER = 'mocap4r2_msgs/msg/Marker'
_RIGID_BODY = 'mocap4r2_msgs/msg/RigidBody'
_RIGID_BODIES = 'mocap4r2_msgs/msg/RigidBodies'

RigidBodies = message_class(
    _RIGID_BODIES,
    {
        _MARKER: 'int8 id_type\nint32 marker_index\nstring marker_name\n'
        'geometry_msgs/Point translation',
        _RIGID_BODY: f'string rigid_body_name\n{_MARKER}[] markers\ngeometry_msgs/Pose pose',
        _RIGID_BODIES: f'std_msgs/Header header\nuint32 frame_number\n{_RIGID_BODY}[] rigidbodies',
    },
)
