"""Mark on topics derived from others by a recorder."""

from __future__ import annotations

from rosbags.interfaces import Connection

DERIVED = '# The recorder of setcmas made these messages from the odometry in this bag.\n'
"""First line of their definition: a comment, which is not part of the type's hash."""


def is_derived(connection: Connection) -> bool:
    """Return whether a connection's messages were made from those of others."""
    return connection.msgdef.data.startswith(DERIVED)
