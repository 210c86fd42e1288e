"""Environment of the processes of a command."""

from __future__ import annotations

import os
import socket
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress

from launch_scripts.processes.installed_ros import check_ros
from launch_scripts.terminal.terminal import LOG_FORMAT
from setcmas_simu.errors import SetcmasError


def clean_environment() -> None:
    """Remove variables that break this process or its children from the environment.

    PYTHONWARNINGS=error turns warnings of ROS into errors; notebooks set MPLBACKEND to a backend
    that exists in their kernel only.
    """
    os.environ.pop('PYTHONWARNINGS', None)
    if sys.warnoptions:
        warnings.resetwarnings()
        warnings.simplefilter('ignore')
    if os.environ.get('MPLBACKEND', '').startswith('module://'):
        del os.environ['MPLBACKEND']


_MIDDLEWARE = 'rmw_fastrtps_cpp'
_LARGEST_DOMAIN = 101  # above, ports collide with those that systems assign
_DISCOVERY_RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
_LEAVING = (
    'ROS_STATIC_PEERS',
    'ROS_DISCOVERY_SERVER',
    'ROS_SUPER_CLIENT',
    'FASTRTPS_DEFAULT_PROFILES_FILE',
)
"""Variables through which topics may leave this machine despite the discovery range."""


def require_ros(without: str = '') -> None:
    """Check that ROS 2 works here and that the ROS domain is valid.

    Args:
        without: What the user can do without ROS, for the message; may be empty.

    Raises:
        SetcmasError: ROS 2 is missing (the message says how to get it) or does not work, or
            ROS_DOMAIN_ID is invalid.
    """
    domain = os.environ.get('ROS_DOMAIN_ID') or '0'
    if not domain.isdecimal() or int(domain) > _LARGEST_DOMAIN:
        raise SetcmasError(
            f"ROS_DOMAIN_ID is '{domain}'; it must be 0 to {_LARGEST_DOMAIN}, or unset"
        )
    middleware = os.environ.get('RMW_IMPLEMENTATION', _MIDDLEWARE)
    if middleware != _MIDDLEWARE and 'AMENT_PREFIX_PATH' not in os.environ:
        raise SetcmasError(
            f"RMW_IMPLEMENTATION is '{middleware}', but PyPI only has {_MIDDLEWARE}: "
            'unset RMW_IMPLEMENTATION'
        )
    check_ros(without)


def local_environment() -> dict[str, str]:
    """Return an environment in which topics stay on this machine: students see only their robots.

    ROS_AUTOMATIC_DISCOVERY_RANGE overrides it.
    """
    return _environment('LOCALHOST')


def closed_environment() -> dict[str, str]:
    """Return an environment in which topics stay on this machine, whatever the user has set.

    Emulated robots have the names of real robots, which must not receive their commands.
    """
    environment = _environment('LOCALHOST') | {_DISCOVERY_RANGE: 'LOCALHOST'}
    return {name: value for name, value in environment.items() if name not in _LEAVING}


def lab_environment(static_peers: Sequence[str]) -> dict[str, str]:
    """Return an environment in which topics reach other machines; the user's settings win.

    Args:
        static_peers: Addresses of the other machines, for networks without multicast.

    Raises:
        SetcmasError: A static peer has an unknown name: ROS would not start.
    """
    environment = _environment('SUBNET')
    if static_peers:
        environment.setdefault('ROS_STATIC_PEERS', ';'.join(static_peers))
    for peer in filter(None, environment.get('ROS_STATIC_PEERS', '').split(';')):
        try:
            socket.getaddrinfo(peer, None)
        except (OSError, UnicodeError) as error:
            raise SetcmasError(
                f"unknown static peer '{peer}'; must be an address, such as 192.168.1.21, or the "
                'name of a machine on this network'
            ) from error
    return environment


def own_address() -> str:
    """Return the address of this machine in its network; '' without a network."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe, suppress(OSError):
        probe.connect(('192.0.2.1', 9))  # an address of no network: nothing is sent
        return str(probe.getsockname()[0])
    return ''


def _environment(discovery_range: str) -> dict[str, str]:
    environment = dict(os.environ)
    environment.setdefault(_DISCOVERY_RANGE, discovery_range)
    if environment.get('ROS_DISCOVERY_SERVER'):
        # Recorder and bridge need the whole graph: all publishers and subscribers.
        environment.setdefault('ROS_SUPER_CLIENT', 'TRUE')
    environment.setdefault('RCUTILS_CONSOLE_OUTPUT_FORMAT', LOG_FORMAT)
    environment.setdefault('RCUTILS_COLORIZED_OUTPUT', '0')
    environment['PYTHONUNBUFFERED'] = '1'
    environment['PYTHONHASHSEED'] = '0'  # equal runs visit sets in the same order
    if 'PYTHONPATH' in environment:  # an empty entry would be the current folder
        folders = environment['PYTHONPATH'].split(os.pathsep)
        environment['PYTHONPATH'] = os.pathsep.join(f for f in folders if f not in ('', '.'))
    return environment
