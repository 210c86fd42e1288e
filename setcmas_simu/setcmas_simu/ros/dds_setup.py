"""Setup of Fast DDS: fast discovery, and UDP as the only transport.

What depends on the version of Fast DDS (2.14 in ROS 2 Jazzy) is here and in its profiles.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Mapping
from pathlib import Path

import rclpy

_PROFILES = 'FASTRTPS_DEFAULT_PROFILES_FILE'
_RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
_WAYS_OUT = ('ROS_STATIC_PEERS', 'ROS_DISCOVERY_SERVER')
_PUBLICATION_MODE = 'RMW_FASTRTPS_PUBLICATION_MODE'
_TRANSPORTS = 'FASTDDS_BUILTIN_TRANSPORTS'
_UDP = 'UDPv4'

_CONFIG = Path(__file__).parents[1] / 'config'
_NETWORK, _LOOPBACK = (str(_CONFIG / f'fastdds_{reach}.xml') for reach in ('network', 'loopback'))


@contextlib.contextmanager
def dds_setup() -> Iterator[None]:
    """Configure Fast DDS for participants created inside, unless the user has configured it.

    On one machine Fast DDS 2.14 prefers shared memory. There a process that hangs while it holds
    the lock of its queue blocks everyone who sends to it (SharedMemGlobal::Port::try_push),
    including those who must stop its robots; a process that is starved for a second may never
    receive anything again; and a killed process leaves files behind. UDP senders never wait for a
    receiver. In the range LOCALHOST rmw_fastrtps insists on shared memory, so a profile with only
    the loopback interface replaces that range.
    """
    # Asynchronously, a velocity would reach si_to_uni in the same process only a step later.
    os.environ[_PUBLICATION_MODE] = 'SYNCHRONOUS'
    fast_dds = rclpy.get_rmw_implementation_identifier().startswith('rmw_fastrtps')
    if not fast_dds or os.environ.get(_PROFILES, _NETWORK) not in (_NETWORK, _LOOPBACK):
        yield
        return
    if os.environ.get(_TRANSPORTS, _UDP) != _UDP:
        os.environ.pop(_PROFILES, None)  # set by the parent process
        yield
        return
    loopback = is_loopback_enough(os.environ)
    os.environ[_PROFILES] = _LOOPBACK if loopback else _NETWORK
    if not loopback:
        yield
        return
    os.environ[_RANGE] = 'SYSTEM_DEFAULT'  # leaves the range to the profile
    try:
        yield
    finally:
        os.environ[_RANGE] = 'LOCALHOST'


def is_loopback_enough(environment: Mapping[str, str]) -> bool:
    """Return whether topics stay on this machine."""
    on_this_machine = environment.get(_RANGE) == 'LOCALHOST'
    return on_this_machine and not any(environment.get(name) for name in _WAYS_OUT)
