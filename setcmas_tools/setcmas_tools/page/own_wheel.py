"""The wheel of the installed setcmas, which a browser installs."""

from __future__ import annotations

import base64
import hashlib
import importlib.util
from importlib.metadata import Distribution, distribution
from pathlib import Path

from setcmas_simu.errors import SetcmasError

PACKAGES = ('setcmas_simu', 'setcmas_ctrl', 'setcmas_expe', 'setcmas_tools', 'launch_scripts')
_WITH = ('tabulate',)
"""Python packages that a browser does not get otherwise."""

_WHEEL = 'Wheel-Version: 1.0\nGenerator: setcmas\nRoot-Is-Purelib: true\nTag: py3-none-any\n'
_METADATA = ('METADATA', 'entry_points.txt')


def own_wheel(left_out: tuple[str, ...] = ()) -> tuple[str, dict[str, bytes]]:
    """Return the name of a wheel of the installed setcmas, and its files by path.

    It is built from the installed files, even of an editable installation, with those of packages
    that Pyodide lacks, and only depends on them.

    Args:
        left_out: Beginnings of paths of files that it does not need.

    Raises:
        SetcmasError: setcmas was not installed by pip.
    """
    installed = _installed()
    stem = f'setcmas-{installed.version}'
    files = {
        f'{package}/{path.relative_to(folder).as_posix()}': path.read_bytes()
        for package, folder in _folders().items()
        for path in sorted(folder.rglob('*'))
        if path.is_file() and '__pycache__' not in path.parts
    }
    files = {path: one for path, one in files.items() if not path.startswith(left_out)}
    for name in _METADATA:
        files[f'{stem}.dist-info/{name}'] = (installed.read_text(name) or '').encode()
    files[f'{stem}.dist-info/WHEEL'] = _WHEEL.encode()
    record = f'{stem}.dist-info/RECORD'
    files[record] = _record(files, record).encode()
    return f'{stem}-py3-none-any.whl', files


def _folders() -> dict[str, Path]:
    """Return the folder of each package."""
    specs = {package: importlib.util.find_spec(package) for package in PACKAGES + _WITH}
    return {name: Path(spec.origin).parent for name, spec in specs.items() if spec and spec.origin}


def _installed() -> Distribution:
    try:
        return distribution('setcmas')
    except ModuleNotFoundError as error:
        raise SetcmasError(
            'setcmas must be installed with pip for this; in a virtual environment: '
            "pip install '.' in its cloned folder"
        ) from error


def _record(files: dict[str, bytes], itself: str) -> str:
    """Return the lines of RECORD: the path, hash and size of each file."""
    lines = []
    for path, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b'=').decode()
        lines.append(f'{path},sha256={digest},{len(content)}\n')
    return ''.join([*lines, f'{itself},,\n'])
