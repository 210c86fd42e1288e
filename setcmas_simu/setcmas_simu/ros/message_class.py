"""Python class of a message type, where its package is installed."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class NoPythonTypeError(Exception):
    """The Python package of a message type is not installed."""


def message_class(msgtype: str) -> Any:
    """Return the class of a type such as `nav_msgs/msg/Odometry`, or raise NoPythonTypeError."""
    package, kind, name = msgtype.split('/')
    try:
        return getattr(import_module(f'{package}.{kind}'), name)
    except (ImportError, AttributeError) as error:
        raise NoPythonTypeError(f'no Python package {package} with it is installed') from error
