"""Folder of the page that runs laws: its own files, setcmas itself, and where Pyodide is."""

from __future__ import annotations

import base64
import hashlib
import json
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib import resources
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from setcmas_ctrl.laws.script_imports import with_helpers
from setcmas_simu import __version__
from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_tools.grade.rubric import read_rubric
from setcmas_tools.grade.rubric_handout import archive, handout
from setcmas_tools.page.document import site_files
from setcmas_tools.page.site_catalogue import catalogue
from setcmas_tools.run.scenario import Scenario
from setcmas_tools.run.scenario_files import OF_FILES, ScenarioFolder, built_in_name

CDN = 'https://cdn.jsdelivr.net/pyodide/v{version}/full/'

FIRST, LATER = ('numpy', 'pyyaml'), ('matplotlib',)
"""Packages for the first run, and for plots."""

LOCK, PARTS = 'pyodide-lock.json', 'python.json'
SETCMAS, GIVEN = 'setcmas.zip', 'given.zip'
"""Archives of the installed packages, and of the rubrics and scenarios of the page."""

Files = dict[str, bytes]


def site(exercises: Sequence[str] = (), scenarios: Sequence[Path] = (), place: str = '') -> Files:
    """Return the files of the page, by path, or raise SetcmasError.

    Args:
        exercises: Names of exercises, or paths of rubrics; all shipped exercises if empty.
        scenarios: Scenario files.
        place: Folder or address of Pyodide; '' is that of jsDelivr.
    """
    is_folder = bool(place) and '://' not in place
    known = json.loads((resources.files(__package__) / 'templates/site/pyodide.json').read_text())
    lock, core, version = known['lock'], known['core'], known['lock']['info']['version']
    if is_folder:
        address, lock = 'pyodide/', _lock(Path(place), version)
        core = {name: _sha256(_content(Path(place), name)) for name in core}
    else:
        address = _address(place or CDN.format(version=version))
    first, later = _parts(lock, core, address)
    rubrics = [Path(one) for one in exercises if _is_file(one)]
    names = [one for one in exercises if not _is_file(one)]
    offered = catalogue(names, rubrics, scenarios)
    own = {
        SETCMAS: archive(installed_packages()),
        GIVEN: archive(dict([*_given_rubrics(rubrics), *_given_scenarios(scenarios)])),
        LOCK: json.dumps(lock).encode(),
    }
    parts = {
        'first': [*first, *(_part(one, one, _sha256(own[one])) for one in own)],
        'later': later,
        'packages': FIRST,
        'later_packages': LATER,
    }
    origin = '' if is_folder else '{0.scheme}://{0.netloc}'.format(urlsplit(address))
    texts = site_files(__version__, origin)
    texts |= {'catalogue.json': json.dumps(offered), PARTS: json.dumps(parts)}
    files = {path: text.encode() for path, text in texts.items()} | own
    return files | _copied(Path(place), first + later) if is_folder else files


def _address(text: str) -> str:
    parts = urlsplit(text)
    is_safe = parts.scheme == 'https' or parts.hostname in ('localhost', '127.0.0.1')
    if not (is_safe and parts.netloc) or any(letter in text for letter in '"\'<>; ?#'):
        raise SetcmasError(
            f"--pyodide is '{text}'; it must be a folder, or an address such as "
            'https://cdn.example.org/pyodide/'
        )
    return text.rstrip('/') + '/'


def _copied(folder: Path, parts: Iterable[Mapping[str, str]]) -> Files:
    """Return the contents of parts, by their addresses, or raise SetcmasError."""
    files = {}
    for one in parts:
        content = _content(folder, one['name'])
        if one['integrity'] != _integrity(_sha256(content)):
            raise SetcmasError(f"'{folder / one['name']}' is not the file that {LOCK} lists")
        files[one['address']] = content
    return files


def _lock(folder: Path, version: str) -> dict[str, Any]:
    """Return the lock of a folder, with the packages that the page needs."""
    if not folder.is_dir():
        raise SetcmasError(f"--pyodide is '{folder}'; it must be a folder, or an address")
    try:
        lock = json.loads(_content(folder, LOCK))
        found = lock['info']['version']
        if found != version:
            raise SetcmasError(f"'{folder}' has Pyodide {found}; it must be {version}")
        names = _closure(lock['packages'], (*FIRST, *LATER))
        return {**lock, 'packages': {name: lock['packages'][name] for name in names}}
    except (ValueError, TypeError, KeyError) as error:
        raise SetcmasError(
            f"'{folder / LOCK}' does not list what the page needs: {error}"
        ) from error


def _content(folder: Path, name: str) -> bytes:
    try:
        return (folder / name).read_bytes()
    except OSError as error:
        raise SetcmasError(
            f"'{folder}' lacks '{name}' of Pyodide: {error.strerror}; unpack the whole release"
        ) from error


def _closure(packages: Mapping[str, Any], names: Iterable[str]) -> list[str]:
    """Return packages with all that they depend on, in a fixed order."""
    found: set[str] = set()
    waiting = [*names]
    while waiting:
        name = waiting.pop().lower()
        if name not in found:
            found.add(name)
            waiting += packages[name]['depends']
    return sorted(found)


def _parts(
    lock: Mapping[str, Any], core: Mapping[str, str], address: str
) -> tuple[list[dict[str, str]], list[dict[str, str]]]:
    """Return name, address and digest of the files for the first run, and of those for plots."""
    packages = lock['packages']
    early = _closure(packages, FIRST)
    late = [name for name in _closure(packages, LATER) if name not in early]
    files = {name: _part(name, address + name, digest) for name, digest in core.items()}
    wheels = {
        name: _part(one['file_name'], address + one['file_name'], one['sha256'])
        for name, one in packages.items()
    }
    return [*files.values(), *(wheels[name] for name in early)], [wheels[name] for name in late]


def _part(name: str, address: str, digest: str) -> dict[str, str]:
    return {'name': name, 'address': address, 'integrity': _integrity(digest)}


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _integrity(digest: str) -> str:
    return f'sha256-{base64.b64encode(bytes.fromhex(digest)).decode()}'


def _is_file(exercise: str) -> bool:
    return exercise.endswith(('.yaml', '.yml'))


def _given_rubrics(rubrics: Iterable[Path]) -> Iterator[tuple[str, bytes]]:
    """Yield path and content of what students may see of rubrics."""
    for file in rubrics:
        for path, content in handout(read_rubric(file)).items():
            yield f'rubrics/{file.stem}/{path}', content


def _given_scenarios(scenarios: Iterable[Path]) -> Iterator[tuple[str, bytes]]:
    """Yield path and content of scenarios and of the files that they name.

    Raises:
        SetcmasError: One is outside the scenario's folder.
    """
    for file in scenarios:
        scenario, folder = Scenario.load(file), file.resolve().parent
        named = [Path(text) for name in OF_FILES for text in scenario.named(name)]
        own = [one for one in named if one.is_absolute() and not built_in_name(one)]
        ScenarioFolder(folder).check_inside(own, file.name)
        for one in dict.fromkeys(file for path in own for file in with_helpers(path)):
            yield f'scenarios/{file.stem}/{one.relative_to(folder).as_posix()}', one.read_bytes()
        yield f'scenarios/{file.stem}/{file.stem}.yaml', file.read_bytes()


def check_folder(folder: Path, overwrite: bool) -> None:
    """Check that a page can be written to a folder, before it is made, or raise SetcmasError."""
    if not folder.absolute().parent.is_dir():
        raise SetcmasError(f"there is no folder '{folder.absolute().parent}'; create it")
    if not folder.exists() or (folder.is_dir() and not any(folder.iterdir())):
        return
    if not (folder / PARTS).is_file():
        raise SetcmasError(f"'{folder}' exists and is no page of setcmas; choose another folder")
    if not overwrite:
        raise SetcmasError(f"'{folder}' exists; --overwrite replaces it")


def write_folder(folder: Path, files: Files) -> None:
    """Write a folder whole, in place of the page that is there, or raise SetcmasError."""
    target = folder.absolute()
    with (
        file_errors(f"'{folder}' cannot be written"),
        tempfile.TemporaryDirectory(prefix='.site-', dir=target.parent) as name,
    ):
        new, old = Path(name) / 'new', Path(name) / 'old'
        for path, content in files.items():
            (new / path).parent.mkdir(parents=True, exist_ok=True)
            (new / path).write_bytes(content)
        if target.exists():
            target.rename(old)
        new.rename(target)
        shutil.rmtree(old, ignore_errors=True)


_PACKAGES = ('setcmas_simu', 'setcmas_ctrl', 'setcmas_expe', 'setcmas_tools', 'tabulate')
"""Packages of setcmas that run laws, and one that Pyodide lacks."""

_NEEDLESS = (
    'setcmas_tools/page/templates/site/',
    'setcmas_tools/bags/',
    'setcmas_ctrl/controllers/',
    *(f'setcmas_expe/{room}/' for room in ('doctor', 'emulation', 'guard', 'pause')),
)
"""Beginnings of paths of files that the page does not need."""

_METADATA = ('METADATA', 'entry_points.txt')
"""Files in which Python finds the version of setcmas, and its laws by name."""


def installed_packages() -> Files:
    """Return the files of setcmas that run laws, and its metadata, by their paths in an archive.

    Raises:
        SetcmasError: setcmas was not installed by pip.
    """
    try:
        installed = distribution('setcmas')
    except PackageNotFoundError as error:
        raise SetcmasError(
            'setcmas must be installed with pip for this; in a virtual environment: '
            "pip install '.' in its cloned folder"
        ) from error
    files = {}
    for package in _PACKAGES:
        folder = Path(str(resources.files(package)))
        for path in sorted(folder.rglob('*')):
            name = f'{package}/{path.relative_to(folder).as_posix()}'
            is_needed = '__pycache__' not in path.parts and not name.startswith(_NEEDLESS)
            if path.is_file() and is_needed:
                files[name] = path.read_bytes()
    for name in _METADATA:
        place = f'setcmas-{installed.version}.dist-info/{name}'
        files[place] = (installed.read_text(name) or '').encode()
    return files
