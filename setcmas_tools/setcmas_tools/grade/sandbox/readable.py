"""Files that a submission may read: Python and installed packages, but no control law of ours."""

from __future__ import annotations

import os
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from importlib.metadata import distributions
from pathlib import Path

_PACKAGES = ('site-packages', 'dist-packages')
_OURS = {'setcmas', 'setcmas_*', 'launch_scripts', '_setcmas*'}
_SHARED = ('/lib', '/lib64', '/usr/lib', '/usr/lib64', '/usr/local/lib', f'{sys.base_prefix}/lib')
_SINGLE = (
    '/dev/null', '/dev/zero', '/dev/random', '/dev/urandom', '/etc/ld.so.cache', '/etc/localtime',
    '/usr/share/zoneinfo',
)  # fmt: skip


def readable() -> tuple[list[Path], list[Path]]:
    """Return the files and folders that may be read, and the folders that may be listed only.

    Packages of plugins are left out like our own: the solutions of a course may be in one.
    """
    standard = {Path(sysconfig.get_path(name)).resolve() for name in ('stdlib', 'platstdlib')}
    packages = {Path(one).resolve() for one in sys.path if Path(one).name in _PACKAGES}
    hidden = {folder / name for folder in standard for name in _PACKAGES} - packages
    hidden |= {*_hidden(packages)}
    listed: list[Path] = []
    read = {path for root in standard | packages for path in _without(root, hidden, listed)}
    for root in {Path(name).resolve() for name in _SHARED}:
        inside = _without(root, {*hidden, *root.glob('python*')}, listed)
        read |= {path for path in inside if path != root}
    read |= {Path(name) for name in _SINGLE if Path(name).exists()}
    return sorted(read), sorted({*listed, *packages})


def _hidden(packages: Iterable[Path]) -> Iterator[Path]:
    """Yield what must not be read in folders of packages."""
    entries = [entry for one in distributions() for entry in one.entry_points]
    plugins = {e.module.partition('.')[0] for e in entries if e.group.startswith('setcmas.')}
    for folder in packages:
        for name in _OURS | plugins:
            yield from folder.glob(name)
            yield from folder.glob(f'{name}.py')


def _without(folder: Path, hidden: set[Path], listed: list[Path]) -> Iterator[Path]:
    """Yield a folder, or what is in it where something there is hidden; notes such folders."""
    if folder in hidden or not os.access(folder, os.R_OK):
        return
    if not any(path.is_relative_to(folder) for path in hidden):
        yield folder
        return
    listed.append(folder)
    for inside in folder.iterdir():
        yield from _without(inside, hidden, listed)
