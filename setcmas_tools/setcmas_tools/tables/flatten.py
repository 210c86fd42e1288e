"""Flattening of messages to CSV cells, by functions that are compiled once for each type."""

from __future__ import annotations

from rosbags.interfaces import Nodetype
from rosbags.typesys.store import Typestore

from setcmas_tools.tables.flattening_code import Flattener, FlatteningCode

_QUATERNION = 'geometry_msgs/msg/Quaternion'
_ORIENTATIONS = (
    'orientation',
    'pose.orientation',
    'pose.pose.orientation',
    'rotation',
    'transform.rotation',
)


def flattener(store: Typestore, msgtype: str) -> Flattener:
    """Compile the flattener of a type.

    Fields are joined by dots (`pose.pose.position.x`), arrays are numbered (`name[0]`), times and
    durations are one column in s with 9 decimals, booleans are 0 and 1. An array with more than
    `LONGEST_ARRAY` elements, such as an image, is one column with its length (`data.length`). A
    message with a pose, a transform or an orientation has a last column `yaw` in rad.

    Args:
        store: Holds the definitions of the type and of all that it is made of.
        msgtype: Name of the type, such as `nav_msgs/msg/Odometry`.
    """
    code = FlatteningCode(store)
    code.add_fields('message', msgtype, '')
    if orientation := _orientation(store, msgtype):
        code.add_yaw(f'message.{orientation}')
    return code.compile()


def _orientation(store: Typestore, msgtype: str) -> str | None:
    for path in _ORIENTATIONS:
        found: str | None = msgtype
        for name in path.split('.'):
            fields = dict(store.fielddefs[found][1]) if found else {}
            kind, detail = fields.get(name, (None, None))
            found = detail if kind == Nodetype.NAME else None
        if found == _QUATERNION:
            return path
    return None
