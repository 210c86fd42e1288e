"""Environment of the processes of a command, and the ROS 2 that Python finds there."""

from __future__ import annotations

import importlib.util
import os
import platform
import socket
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from launch_scripts.terminal import LOG_FORMAT
from setcmas_simu.errors import SetcmasError, install_command

_PACKAGES = ('rclpy', 'geometry_msgs', 'nav_msgs', 'std_msgs', 'visualization_msgs')
_ON_PYPI = ('Linux', 'x86_64')
_SOURCE_IT = 'source the setup.bash of an installed ROS 2 Jazzy'
_TRIAL = """
from geometry_msgs.msg import PoseWithCovariance
from rclpy.serialization import serialize_message
serialize_message(PoseWithCovariance())
"""
"""A message with an array of numpy: its code must fit this Python and this numpy."""


def missing_ros() -> str:
    """Return the first missing Python package of ROS 2; '' if all are installed."""
    for name in _PACKAGES:
        found = importlib.util.find_spec(name)
        if found is None or found.origin is None:  # an empty folder has no origin
            return name
    return ''


def check_ros(without: str = '') -> None:
    """Check that there is one ROS 2, and that it works with this Python and this numpy.

    Args:
        without: What the user can do without ROS, for the message; may be empty.

    Raises:
        SetcmasError: It is missing, there are two, or it was built for others.
    """
    if missing := missing_ros():
        raise SetcmasError(f'ROS 2 Jazzy is missing ({missing}): {without}{_how_to_get_it()}')
    first, *others = _folders()
    if others:
        raise SetcmasError(
            f'ROS 2 is installed twice, in {first} and {others[0]}: use a terminal in which no '
            "setup.bash is sourced, or 'pip uninstall ros-jazzy-rclpy'"
        )
    if first.is_relative_to(Path(sys.prefix).resolve()):
        return  # pip has seen to it
    trial = subprocess.run([sys.executable, '-c', _TRIAL], capture_output=True, text=True)
    if trial.returncode:
        reason = (trial.stderr.strip().splitlines() or [f'status {trial.returncode}'])[-1]
        raise SetcmasError(
            f'the ROS 2 in {first} does not work with Python {platform.python_version()} '
            f"({sys.executable}): use the system's python3, or a virtual environment made with "
            f"it, and pip install 'numpy<2'; its error: {reason}"
        )


def _folders() -> list[Path]:
    """Return the folders from which Python could import rclpy, the one that it takes first."""
    folders = (Path(entry).resolve() for entry in sys.path if entry)
    return list(dict.fromkeys(one for one in folders if (one / 'rclpy' / '__init__.py').is_file()))


def _how_to_get_it() -> str:
    if (platform.system(), platform.machine()) == _ON_PYPI:
        return f'{install_command("ros")} installs it; or {_SOURCE_IT}'
    return (
        f'PyPI has it for {" on ".join(_ON_PYPI)} only, not for {platform.system()} on '
        f'{platform.machine()}; {_SOURCE_IT} (Ubuntu 24.04: apt-get install ros-jazzy-ros-base)'
    )


def clean_environment() -> None:
    """Remove the matplotlib backend that notebooks set: it works in their kernel only."""
    if os.environ.get('MPLBACKEND', '').startswith('module://'):
        del os.environ['MPLBACKEND']


_MIDDLEWARE = 'rmw_fastrtps_cpp'
_LARGEST_DOMAIN = 232  # its ports are the last ones that UDP has
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
    # Idle threads of OpenBLAS spin for 0.1 s of processor time when numpy is imported, a third of
    # what a process of nodes takes to start (benchmarks/fleet.py, 2 cores of an AMD EPYC).
    environment.setdefault('OPENBLAS_NUM_THREADS', '1')
    if 'PYTHONPATH' in environment:  # an empty entry would be the current folder
        folders = environment['PYTHONPATH'].split(os.pathsep)
        environment['PYTHONPATH'] = os.pathsep.join(f for f in folders if f not in ('', '.'))
    return environment
