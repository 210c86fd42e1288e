"""Environment of the processes of a command."""

from __future__ import annotations

import importlib.util
import os
import socket
import sys
import warnings
from collections.abc import Sequence

from launch_scripts.terminal.terminal_output import LOG_FORMAT
from setcmas_simu.errors import SetcmasError, install_command


def leave_out_what_breaks() -> None:
    """Take out of the environment what would end this process or one that it starts.

    PYTHONWARNINGS=error makes errors of the remarks of other packages, ROS among them; a notebook
    sets MPLBACKEND to a backend that exists in its own kernel only.
    """
    os.environ.pop('PYTHONWARNINGS', None)
    if sys.warnoptions:
        warnings.resetwarnings()
        warnings.simplefilter('ignore')
    if os.environ.get('MPLBACKEND', '').startswith('module://'):
        del os.environ['MPLBACKEND']


_ROS_PACKAGES = ('rclpy', 'geometry_msgs', 'nav_msgs', 'std_msgs', 'visualization_msgs')
_MIDDLEWARE = 'rmw_fastrtps_cpp'
_LARGEST_DOMAIN = 101  # beyond, ports collide with those that systems hand out
_DISCOVERY_RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
_WAYS_OUT = (
    'ROS_STATIC_PEERS',
    'ROS_DISCOVERY_SERVER',
    'ROS_SUPER_CLIENT',
    'FASTRTPS_DEFAULT_PROFILES_FILE',
    'FASTDDS_DEFAULT_PROFILES_FILE',
)
"""Variables by which topics may reach other machines whatever the discovery range."""


def missing_ros() -> str:
    """Return the first of ROS 2's Python packages that is missing; empty if none is."""
    missing = (name for name in _ROS_PACKAGES if importlib.util.find_spec(name) is None)
    return next(missing, '')


def require_ros(without: str = '') -> None:
    """See that ROS 2's Python packages are there and can take part in a ROS domain.

    Args:
        without: What can be done without ROS, if anything, for the message.

    Raises:
        SetcmasError: They are not, the message says how to install them; or ROS_DOMAIN_ID is
            none.
    """
    domain = os.environ.get('ROS_DOMAIN_ID') or '0'
    if not domain.isdecimal() or int(domain) > _LARGEST_DOMAIN:
        raise SetcmasError(
            f"ROS_DOMAIN_ID is '{domain}'; it must be 0 to {_LARGEST_DOMAIN}, or unset"
        )
    middleware = os.environ.get('RMW_IMPLEMENTATION', _MIDDLEWARE)
    if middleware != _MIDDLEWARE and 'AMENT_PREFIX_PATH' not in os.environ:
        raise SetcmasError(
            f"RMW_IMPLEMENTATION is '{middleware}', and only {_MIDDLEWARE} comes from PyPI: "
            'unset RMW_IMPLEMENTATION'
        )
    if missing := missing_ros():
        raise SetcmasError(
            f'ROS 2 Jazzy is needed and {missing} is missing: {without}{install_command("ros")} '
            'installs it on Linux; or source the setup.bash of an installed ROS 2 Jazzy'
        )


def local_environment() -> dict[str, str]:
    """Return the environment of processes whose topics stay on this machine.

    In a classroom every student's robots are their own; whoever sets
    ROS_AUTOMATIC_DISCOVERY_RANGE decides otherwise.
    """
    return _environment('LOCALHOST')


def closed_environment() -> dict[str, str]:
    """Return the environment of processes whose topics stay on this machine whatever is set.

    Emulated robots have the names of real ones, which must not hear what those are commanded.
    """
    environment = _environment('LOCALHOST') | {_DISCOVERY_RANGE: 'LOCALHOST'}
    return {name: value for name, value in environment.items() if name not in _WAYS_OUT}


def lab_environment(static_peers: Sequence[str], discovery_server: str) -> dict[str, str]:
    """Return the environment of processes that talk to other machines.

    What the user has set goes first.

    Args:
        static_peers: Addresses of the other machines, for networks without multicast.
        discovery_server: Its address:port; empty if there is none.

    Raises:
        SetcmasError: A static peer has a name that is not known here; ROS would start nothing.
    """
    environment = _environment('SUBNET', discovery_server)
    if static_peers:
        environment.setdefault('ROS_STATIC_PEERS', ';'.join(static_peers))
    for peer in filter(None, environment.get('ROS_STATIC_PEERS', '').split(';')):
        _check_name(peer)
    return environment


def _check_name(peer: str) -> None:
    try:
        socket.getaddrinfo(peer, None)
    except (OSError, UnicodeError) as error:
        raise SetcmasError(
            f"static peer '{peer}' is not known on this network; it must be an address, such as "
            '192.168.1.21, or the name of a machine'
        ) from error


def _environment(discovery_range: str, discovery_server: str = '') -> dict[str, str]:
    environment = dict(os.environ)
    environment.setdefault(_DISCOVERY_RANGE, discovery_range)
    if discovery_server:
        environment.setdefault('ROS_DISCOVERY_SERVER', discovery_server)
    if environment.get('ROS_DISCOVERY_SERVER'):
        # Recorder and bridge look at the whole graph: who publishes, who listens.
        environment.setdefault('ROS_SUPER_CLIENT', 'TRUE')
    environment.setdefault('RCUTILS_CONSOLE_OUTPUT_FORMAT', LOG_FORMAT)
    environment.setdefault('RCUTILS_COLORIZED_OUTPUT', '0')
    environment['PYTHONUNBUFFERED'] = '1'
    if 'PYTHONPATH' in environment:  # an empty entry would mean the current folder
        folders = environment['PYTHONPATH'].split(os.pathsep)
        environment['PYTHONPATH'] = os.pathsep.join(f for f in folders if f not in ('', '.'))
    return environment
