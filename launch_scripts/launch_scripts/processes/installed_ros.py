"""The ROS 2 that Python finds: none, one that works, or one that does not."""

from __future__ import annotations

import importlib.util
import platform
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

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
            f'ROS 2 is there twice, in {first} and {others[0]}: use a terminal in which no '
            "setup.bash is sourced, or 'pip uninstall ros-jazzy-rclpy'"
        )
    if first.is_relative_to(Path(sys.prefix).resolve()):
        return  # pip has seen to it
    if not list(first.glob(f'rclpy/_rclpy_pybind11.{sys.implementation.cache_tag}*')):
        raise SetcmasError(
            f'the ROS 2 in {first} is for another Python than {platform.python_version()} '
            f"({sys.executable}): use the system's python3, or a virtual environment made with it"
        )
    trial = subprocess.run([sys.executable, '-c', _TRIAL], capture_output=True, text=True)
    if trial.returncode:
        numpy = version('numpy')
        advice = _SOURCE_IT if numpy.startswith('1.') else "pip install 'numpy<2'"
        reason = (trial.stderr.strip().splitlines() or [f'status {trial.returncode}'])[-1]
        raise SetcmasError(
            f'the ROS 2 in {first} does not work with numpy {numpy}: {advice}; its error: {reason}'
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
