"""Where a run came from: the release or commit of setcmas, its packages, the machine."""

from __future__ import annotations

import functools
import platform
import subprocess
from dataclasses import dataclass
from pathlib import Path

from setcmas_simu import __version__

_PACKAGES = ('numpy', 'rclpy', 'rosbags', 'matplotlib')
_ROOT = Path(__file__).parents[3]
_GIT_TIMEOUT_S = 5.0


@dataclass(frozen=True)
class Origin:
    """What a run was made with.

    Attributes:
        setcmas: The release of setcmas, or the commit of a checkout.
        versions: Those of Python and of packages.
        host: Name and system of the machine.
    """

    setcmas: str
    versions: dict[str, str]
    host: dict[str, str]


@functools.cache
def this_origin() -> Origin:
    """Return the origin of runs of this process."""
    found = {name: version for name in _PACKAGES if (version := _version(name))}
    return Origin(
        _commit() or __version__,
        {'python': platform.python_version(), **found},
        {'name': platform.node(), 'system': platform.platform()},
    )


def _version(package: str) -> str | None:
    from importlib import metadata  # slow, and needed only where a run is written

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _commit() -> str | None:
    """Return release and commit of the checkout that this is; None if it is installed."""
    if not (_ROOT / '.git').exists():
        return None
    command = ['git', '-C', str(_ROOT), 'describe', '--always', '--dirty', '--abbrev=12']
    try:
        found = subprocess.run(
            [*command, '--exclude=*'],
            capture_output=True,
            text=True,
            timeout=_GIT_TIMEOUT_S,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return f'{__version__}, commit {found.stdout.strip()}'
