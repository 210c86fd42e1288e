"""Setup of Fast DDS: processes find each other soon, and talk over UDP alone."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Mapping
from importlib import resources

import rclpy

_PROFILE_VARIABLES = ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE')
_RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
_WAYS_OUT = ('ROS_STATIC_PEERS', 'ROS_DISCOVERY_SERVER')
_TRANSPORTS = 'FASTDDS_BUILTIN_TRANSPORTS'
_UDP = 'UDPv4'

_CONFIG = resources.files('setcmas_simu') / 'config'
_NETWORK = str(_CONFIG / 'fastdds_network.xml')
_LOOPBACK = str(_CONFIG / 'fastdds_loopback.xml')


@contextlib.contextmanager
def dds_setup() -> Iterator[None]:
    """Set Fast DDS up for what is initialised inside, unless the user has done so.

    Fast DDS 2.14 prefers shared memory on one machine. There a process that hangs while it holds
    the lock of its queue holds up whoever sends to it (SharedMemGlobal::Port::try_push), and so
    those who are to stop its robots; one that is starved for a second may never get anything
    again; and each one that is killed leaves files behind. Over UDP nobody waits for a receiver.
    In the range LOCALHOST rmw_fastrtps insists on shared memory, so that a profile of ours with
    the loopback interface alone takes the place of that range.
    """
    given = {os.environ[name] for name in _PROFILE_VARIABLES if name in os.environ}
    fast_dds = rclpy.get_rmw_implementation_identifier().startswith('rmw_fastrtps')
    if not fast_dds or given - {_NETWORK, _LOOPBACK}:
        yield
        return
    if os.environ.get(_TRANSPORTS, _UDP) != _UDP:
        os.environ.pop(_PROFILE_VARIABLES[0], None)  # ours, of the process that started this one
        yield
        return
    loopback = is_loopback_enough(os.environ)
    os.environ[_PROFILE_VARIABLES[0]] = _LOOPBACK if loopback else _NETWORK
    if not loopback:
        yield
        return
    os.environ[_RANGE] = 'SYSTEM_DEFAULT'  # what the profile says
    try:
        yield
    finally:
        os.environ[_RANGE] = 'LOCALHOST'


def is_loopback_enough(environment: Mapping[str, str]) -> bool:
    """Return whether topics are to stay on this machine."""
    on_this_machine = environment.get(_RANGE) == 'LOCALHOST'
    return on_this_machine and not any(environment.get(name) for name in _WAYS_OUT)
