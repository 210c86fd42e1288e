"""Confinement of a process by bubblewrap: what the process and students see of the machine."""

from __future__ import annotations

import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from importlib.metadata import distributions
from importlib.util import find_spec
from pathlib import Path

HOME = '/tmp'
"""The only folder of a confined process that can be written, empty at first."""
HOME_SIZE = 1 << 26
"""What it holds, in bytes."""

_BASE = Path(sys.base_prefix).resolve()
_IS_OF_SYSTEM = _BASE.is_relative_to('/usr')
PYTHON = str(Path(_BASE if _IS_OF_SYSTEM else '/python', 'bin', f'python3.{sys.version_info[1]}'))
"""Python in the view of a confined process."""

_TOP, _OURS = '/packages', '/packages/ours'
_SHARED = ('setcmas_simu', 'setcmas_ctrl', 'setcmas_expe', 'setcmas_tools')
_SOLUTIONS = ('algorithms', 'exercises', 'sessions')  # of setcmas_ctrl
_OF_PACKAGES = ('site-packages', 'dist-packages')
_OF_SYSTEM = ('/etc/ld.so.cache', '/etc/alternatives', '/etc/localtime')
_LIBRARIES = ('--symlink', 'usr/lib', '/lib', '--symlink', 'usr/lib64', '/lib64')
_DEVICES = ('/dev/null', '/dev/zero', '/dev/random', '/dev/urandom')
_FOLDERS = ('/dev', '/etc', '/proc', '/tmp', _TOP, _OURS)
_NOBODY = '65534'
_ALONE = (
    '--unshare-all', '--unshare-user', '--disable-userns', '--die-with-parent', '--new-session',
    '--cap-drop', 'ALL', '--size', str(HOME_SIZE), '--tmpfs', HOME, '--chdir', HOME,
    '--remount-ro', '/',
    # Where a Python of its own has its library, which it knows by the folder outside only.
    *(() if _IS_OF_SYSTEM else ('--setenv', 'LD_LIBRARY_PATH', '/python/lib')),
)  # fmt: skip


def package_folders() -> list[str]:
    """Return the folders of packages in the view of a confined process."""
    return [_OURS, *(f'{_TOP}/{number}' for number, _ in enumerate(_folders()))]


@cache
def confining_command() -> list[str]:
    """Return the beginning of a command that confines the program after it.

    The program sees Python, its packages, and of setcmas what scripts may import. For root, an
    outer bubblewrap arranges what only root can read, and the program is nobody: the limit of
    processes does not hold for root.
    """
    arranged = [word for words in _arranged() for word in words]
    # Where memory runs out, the kernel is to end this process first.
    first = ['choom', '-n', '1000', '--'] if shutil.which('choom') else []
    if os.geteuid():
        return [*first, 'bwrap', *arranged, *_ALONE, '--']
    tops = ['/usr', '/etc', _TOP, *([] if _IS_OF_SYSTEM else ['/python'])]
    shown = [word for name in tops for word in ('--ro-bind', name, name)]
    return [
        *first, 'bwrap', '--die-with-parent', '--unshare-pid', *arranged, '--proc', '/proc',
        '--cap-add', 'CAP_SETUID', '--cap-add', 'CAP_SETGID', '--',
        'setpriv', f'--reuid={_NOBODY}', f'--regid={_NOBODY}', '--clear-groups', '--',
        'bwrap', *shown, *_LIBRARIES, *_devices(), *_ALONE, '--',
    ]  # fmt: skip


def _arranged() -> Iterator[tuple[str, ...]]:
    """Yield options for what a confined process sees of the machine."""
    for name in _FOLDERS:
        yield '--perms', '0755', '--dir', name
    yield '--ro-bind', '/usr', '/usr'
    yield _LIBRARIES
    for name in _OF_SYSTEM:
        yield '--ro-bind-try', name, name
    yield _devices()
    for top in ('lib', 'local/lib'):
        for place in Path('/usr', top).glob('python3*/*-packages'):
            yield _hidden(str(place))
    if not _IS_OF_SYSTEM:
        yield '--ro-bind', str(_BASE), '/python'
        for place in _BASE.glob('lib/python3*/site-packages'):
            yield _hidden(f'/python/{place.relative_to(_BASE)}')
    for number, folder in enumerate(_folders()):
        yield '--ro-bind', str(folder), f'{_TOP}/{number}'
        for path in _private(folder):
            hidden = f'{_TOP}/{number}/{path.name}'
            yield _hidden(hidden) if path.is_dir() else ('--ro-bind', '/dev/null', hidden)
    for name in _SHARED:
        if (spec := find_spec(name)) and spec.origin:
            yield '--ro-bind', str(Path(spec.origin).resolve().parent), f'{_OURS}/{name}'
    for name in _SOLUTIONS:
        yield _hidden(f'{_OURS}/setcmas_ctrl/{name}')


def _hidden(place: str) -> tuple[str, ...]:
    return '--tmpfs', place, '--remount-ro', place


def _devices() -> tuple[str, ...]:
    return tuple(word for name in _DEVICES for word in ('--dev-bind', name, name))


@cache
def _folders() -> list[Path]:
    """Return the folders of installed packages."""
    found = (Path(name).resolve() for name in sys.path if Path(name).name in _OF_PACKAGES)
    return [folder for folder in dict.fromkeys(found) if folder.is_dir()]


def _private(folder: Path) -> Iterator[Path]:
    """Yield packages that scripts must not read: ours, and plugins, which may be of a course."""
    entries = [entry for one in distributions() for entry in one.entry_points]
    names = {entry.module.partition('.')[0] for entry in entries if entry.group[:8] == 'setcmas.'}
    for name in {*names, *_SHARED, 'launch_scripts'}:
        yield from (path for path in (folder / name, folder / f'{name}.py') if path.exists())


def obstacle() -> str:
    """Return why submissions cannot be confined here, and what to do; empty if they can."""
    if sys.platform != 'linux':
        return 'bubblewrap runs on Linux only; use Docker or, on Windows, WSL 2'
    if not shutil.which('bwrap'):
        packages = next((one for one in ('apt-get', 'dnf', 'zypper') if shutil.which(one)), '')
        command = f'sudo {packages} install bubblewrap' if packages else 'install bubblewrap'
        return f'bubblewrap is missing; to install it: {command}, or use Docker'
    try:
        done = subprocess.run(
            [*confining_command(), PYTHON, '-c', ''],
            capture_output=True, text=True, errors='replace', stdin=subprocess.DEVNULL,
        )  # fmt: skip
    except OSError as error:
        return f'{error.filename} cannot be run: {error.strerror}'
    if not done.returncode:
        return ''
    reason = done.stderr.strip().rpartition('\n')[2] or f'exit status {done.returncode}'
    return f'{reason.removeprefix("bwrap: ")}; {_remedy(reason)}'


_RESTRICTED = Path('/proc/sys/kernel/apparmor_restrict_unprivileged_userns')
_PROFILE = '/usr/share/apparmor/extra-profiles/bwrap-userns-restrict'


def _remedy(reason: str) -> str:
    """Return what to do where bubblewrap cannot make namespaces."""
    if 'nknown option' in reason:
        return 'bubblewrap 0.8 or later is needed'
    if _RESTRICTED.is_file() and _RESTRICTED.read_text().strip() == '1':
        return (
            "Ubuntu's AppArmor needs its profile for bubblewrap: sudo apt-get install "
            f'apparmor-profiles && sudo install -m 644 {_PROFILE} /etc/apparmor.d/ && '
            'sudo apparmor_parser -r /etc/apparmor.d/bwrap-userns-restrict'
        )
    return (
        f'bubblewrap needs user namespaces, which Linux {platform.release()} does not allow here '
        '(sysctl user.max_user_namespaces); in Docker, add --security-opt seccomp=unconfined '
        '--security-opt apparmor=unconfined'
    )


_TEMPORARY = r'(?:/(?:setcmas_|tmp)[a-z0-9_]{8}(?![a-z0-9_]))+/?'  # as mkdtemp names them
_CUT = re.compile(r'/[^\s\'"]*(?=\.\.\.)')


def without_paths(text: str) -> str:
    """Return a message without the folders of this machine.

    Files of a submission and of packages are relative to its folder or to that of the packages;
    the home, the environment and the current folder of the grading user become '…'.
    """
    temporary = '|'.join(map(re.escape, _places([tempfile.gettempdir()])))
    text = re.sub(f'(?:{temporary}){_TEMPORARY}', '', text)
    packages, private = _places(_roots()), _places(_private_folders())
    for place in packages:
        text = text.replace(f'{place}/', '')
    for place in private:
        text = re.sub(rf'{re.escape(place)}(?![\w.-])', '…', text)
    places = [*packages, *private]

    def shortened(cut: re.Match[str]) -> str:
        return '…' if any(place.startswith(cut[0]) for place in places) else cut[0]

    return _CUT.sub(shortened, text)


def _roots() -> Iterator[str]:
    """Yield the folders of modules; loading a law adds its folder, perhaps a package."""
    yield from (one for one in sys.path if one and not Path(one, '__init__.py').exists())


def _private_folders() -> Iterator[str]:
    yield from (sys.prefix, sys.base_prefix)
    with suppress(OSError, RuntimeError):
        yield str(Path.cwd())
        yield str(Path.home())


def _places(folders: Iterable[str]) -> list[str]:
    """Return folders as given and resolved, longest first; without the root."""
    found = {place for one in folders for place in (one, os.path.realpath(one))}
    return sorted((place.rstrip('/') for place in found if len(place) > 1), key=len, reverse=True)
