"""Autograders of learning platforms: one archive with setcmas, the rubric and its solution."""

from __future__ import annotations

import base64
import hashlib
import importlib.util
import io
import re
import stat
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import resources
from importlib.metadata import Distribution, distribution
from pathlib import Path

from setcmas_simu.errors import SetcmasError

_LONG_AGO = (1980, 1, 1, 0, 0, 0)  # earliest time in the format


def archive(files: Mapping[str, str | bytes]) -> bytes:
    """Return a zip archive of files by path; files that begin with `#!` are executable."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, 'w', zipfile.ZIP_DEFLATED) as target:
        for path, text in files.items():
            data = text.encode() if isinstance(text, str) else text
            info = zipfile.ZipInfo(path, _LONG_AGO)
            mode = 0o755 if data.startswith(b'#!') else 0o644
            info.external_attr = (stat.S_IFREG | mode) << 16
            info.create_system = 3  # Unix, to keep modes
            target.writestr(info, data, zipfile.ZIP_DEFLATED)
    return content.getvalue()


PACKAGES = ('setcmas_simu', 'setcmas_ctrl', 'setcmas_expe', 'setcmas_tools', 'launch_scripts')

_WHEEL = 'Wheel-Version: 1.0\nGenerator: setcmas\nRoot-Is-Purelib: true\nTag: py3-none-any\n'
_METADATA = ('METADATA', 'entry_points.txt')


def own_wheel(left_out: tuple[str, ...] = ()) -> tuple[str, bytes]:
    """Return the name and the content of a wheel of the installed setcmas.

    Args:
        left_out: Beginnings of paths of files that it does not need.

    Raises:
        SetcmasError: setcmas was not installed by pip.
    """
    return wheel_of(_installed(), package_folders(), left_out)


def wheel_of(
    installed: Distribution, folders: Mapping[str, Path], left_out: tuple[str, ...] = ()
) -> tuple[str, bytes]:
    """Return the name and the content of a wheel of an installed package of pure Python.

    It is built from the installed files, even of an editable installation, and only depends on
    them.

    Args:
        installed: The package.
        folders: The folders of its Python packages, by name.
        left_out: Beginnings of paths of files that are left out.
    """
    name = re.sub(r'[-_.]+', '_', installed.metadata['Name']).lower()
    stem = f'{name}-{installed.version}'
    files = {
        f'{package}/{path.relative_to(folder).as_posix()}': path.read_bytes()
        for package, folder in folders.items()
        for path in sorted(folder.rglob('*'))
        if path.is_file() and '__pycache__' not in path.parts
    }
    files = {path: one for path, one in files.items() if not path.startswith(left_out)}
    for name in _METADATA:
        files[f'{stem}.dist-info/{name}'] = (installed.read_text(name) or '').encode()
    files[f'{stem}.dist-info/WHEEL'] = _WHEEL.encode()
    record = f'{stem}.dist-info/RECORD'
    files[record] = _record(files, record).encode()
    return f'{stem}-py3-none-any.whl', archive(files)


def package_folders() -> dict[str, Path]:
    """Return the folder of each package of setcmas."""
    specs = {package: importlib.util.find_spec(package) for package in PACKAGES}
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


@dataclass(frozen=True)
class Kit:
    """Common content of all bundles.

    Attributes:
        title: Title of the rubric.
        wheel: Name of the wheel of setcmas.
        files: Contents by path: the wheel, and the rubric with its files under `rubric/`.
        rubric: Path of the rubric among them.
        options: Further options of `setcmas grade`, such as '--trust'; may be empty.
        plugins: Names of the wheels of plugins that the rubric uses, also in `files`.
    """

    title: str
    wheel: str
    files: Mapping[str, bytes]
    rubric: str
    options: str = ''
    plugins: tuple[str, ...] = ()

    @property
    def wheels(self) -> dict[str, bytes]:
        """All wheels by name, that of setcmas first."""
        return {name: self.files[name] for name in (self.wheel, *self.plugins)}

    def filled_in(self, format_: str) -> dict[str, str]:
        """Return scripts and instructions of a format by name, from its templates."""
        folder = resources.files('setcmas_tools.platforms') / 'templates' / format_
        paths = [path for path in folder.iterdir() if path.name.endswith('.in')]
        texts = {path.name.removesuffix('.in'): path.read_text(encoding='utf-8') for path in paths}
        fields = {name: getattr(self, name) for name in ('wheel', 'rubric', 'options')}
        fields['plugins'] = ''.join(f' ./{name}' for name in self.plugins)
        for field, value in fields.items():
            mark = f'[[{field}]]'
            texts = {name: text.replace(mark, value) for name, text in texts.items()}
        return texts


def rubric_files(
    rubric: Path, files: Iterable[Path], packages: Iterable[Path]
) -> dict[str, bytes]:
    """Return the files of a rubric by their paths in a bundle.

    Args:
        rubric: The rubric.
        files: All its files, itself among them.
        packages: Folders whose files come with setcmas.

    Raises:
        SetcmasError: One is neither in the rubric's folder nor part of setcmas.
    """
    folder = rubric.resolve().parent
    shipped = [package.resolve() for package in packages]
    found = {f'rubric/{rubric.name}': rubric.read_bytes()}
    for path in (file.resolve() for file in files):
        if path.is_relative_to(folder):
            found[f'rubric/{path.relative_to(folder).as_posix()}'] = path.read_bytes()
        elif not any(path.is_relative_to(package) for package in shipped):
            raise SetcmasError(
                f"'{path}' must be in the folder of the rubric, or below; copy it there, and "
                f"change its path in '{rubric}'"
            )
    return found
