"""Folder of the page that runs laws: its own files, its choices, setcmas itself, and Pyodide."""

from __future__ import annotations

import base64
import hashlib
import json
import math
import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import Field, fields
from importlib import resources
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from string import Template
from typing import Any
from urllib.parse import urlsplit

from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES, names_to_set
from setcmas_simu import __version__
from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.option_groups import Option, default_of, plain
from setcmas_simu.option_kinds import Number, Whole
from setcmas_simu.plugins import ScriptGroup
from setcmas_simu.robots.models_by_name import MODELS
from setcmas_tools.grade.rubric import Rubric, read_rubric, rubric_of_exercise
from setcmas_tools.grade.rubric_handout import archive, handout
from setcmas_tools.page.document import (
    MODULES,
    digest,
    escaped,
    json_data,
    page_content,
    template,
)
from setcmas_tools.run.scenario import Scenario

CDN = 'https://cdn.jsdelivr.net/pyodide/v{version}/full/'

FIRST, LATER = ('numpy', 'pyyaml'), ('matplotlib',)
"""Packages for the first run, and for plots."""

LOCK, PARTS = 'pyodide-lock.json', 'python.json'
SETCMAS, RUBRICS = 'setcmas.zip', 'rubrics.zip'
"""Archives of the installed packages, and of the rubrics of the page."""

_TEMPLATES = resources.files(__package__) / 'templates' / 'site'

Files = dict[str, bytes]


def site(exercises: Sequence[str] = (), pyodide: Path | None = None) -> Files:
    """Return the files of the page, by path, or raise SetcmasError.

    Args:
        exercises: Names of exercises, or paths of rubrics; all shipped exercises if empty.
        pyodide: Folder with a release of Pyodide, which is copied; None for jsDelivr's.
    """
    known = json.loads((_TEMPLATES / 'pyodide.json').read_text(encoding='utf-8'))
    lock = _lock(pyodide, known['lock']) if pyodide else known['lock']
    cdn = CDN.format(version=lock['info']['version'])
    address = 'pyodide/' if pyodide else cdn
    core = [_part(name, address + name, digest) for name, digest in known['core'].items()]
    wheels = {
        name: _part(one['file_name'], address + one['file_name'], one['sha256'])
        for name, one in lock['packages'].items()
    }
    later = [wheels.pop(name) for name in sorted(wheels) if name not in FIRST]
    from_pyodide = [*core, *wheels.values(), *later]
    rubrics = [Path(one) for one in exercises if _is_file(one)]
    offered = catalogue([one for one in exercises if not _is_file(one)], rubrics)
    own = {
        SETCMAS: archive(installed_packages()),
        RUBRICS: archive(dict(_given_rubrics(rubrics))),
        LOCK: json.dumps(lock).encode(),
    }
    parts = {
        'first': [*core, *wheels.values(), *(_part(one, one, _sha256(own[one])) for one in own)],
        'later': later,
        'packages': FIRST,
        'later_packages': LATER,
    }
    texts = _page_files('' if pyodide else '{0.scheme}://{0.netloc}'.format(urlsplit(cdn)))
    texts |= {'catalogue.json': json.dumps(offered), PARTS: json.dumps(parts)}
    files = {path: text.encode() for path, text in texts.items()} | own
    return files | _copied(pyodide, from_pyodide) if pyodide else files


def _lock(folder: Path, known: Mapping[str, Any]) -> dict[str, Any]:
    """Return the lock of a folder, with the packages that the page needs."""
    if not folder.is_dir():
        raise SetcmasError(f"--pyodide is '{folder}'; it must be a folder")
    version = known['info']['version']
    try:
        lock = json.loads(_content(folder, LOCK))
        if lock['info']['version'] != version:
            found = lock['info']['version']
            raise SetcmasError(f"'{folder}' has Pyodide {found}; it must be {version}")
        return {**lock, 'packages': {name: lock['packages'][name] for name in known['packages']}}
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


def _copied(folder: Path, parts: Iterable[Mapping[str, str]]) -> Files:
    """Return the contents of parts, by their addresses, or raise SetcmasError."""
    files = {one['address']: _content(folder, one['name']) for one in parts}
    for one in parts:
        if one != _part(one['name'], one['address'], _sha256(files[one['address']])):
            raise SetcmasError(f"'{folder / one['name']}' is not that of the release of Pyodide")
    return files


def _part(name: str, address: str, digest: str) -> dict[str, str]:
    """Return what a page asks for: name, address, and digest (SHA-256, in hexadecimal)."""
    integrity = f'sha256-{base64.b64encode(bytes.fromhex(digest)).decode()}'
    return {'name': name, 'address': address, 'integrity': integrity}


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _page_files(connects: str) -> dict[str, str]:
    """Return the page with its own modules and those of the player, by path.

    `connects` is where it may get Python from, besides its own server; '' for nowhere.
    """
    own = {one.name: one.read_text(encoding='utf-8') for one in _TEMPLATES.iterdir()}
    own['index.html'] = Template(own['index.html']).substitute(
        version=escaped(__version__),
        connects=f' {connects}' if connects else '',
        stage=template('stage.html'),
        data=json_data(page_content()),
    )
    script = own.pop('sandbox.js')
    own['sandbox.html'] = Template(own['sandbox.html']).substitute(
        script=script, digest=digest(script)
    )
    own['style.css'] = template('base.css') + template('style.css') + own.pop('site.css')
    del own['pyodide.json']
    return own | {f'player/{name}': template(name) for name in MODULES}


def _is_file(exercise: str) -> bool:
    return exercise.endswith(('.yaml', '.yml'))


def _given_rubrics(rubrics: Iterable[Path]) -> Iterator[tuple[str, bytes]]:
    """Yield path and content of what students may see of rubrics."""
    for file in rubrics:
        for path, content in handout(read_rubric(file)).items():
            yield f'rubrics/{file.stem}/{path}', content


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


_OFFERED = (
    'nb_robots', 'duration', 'graph', 'range', 'delay', 'loss', 'noise', 'event_triggered',
    'threshold', 'own_state', 'model', 'limits', 'vnom', 'komega', 'rate', 'robot_rate', 'seed',
    'random_poses', 'pose', 'arena', 'obstacles',
)  # fmt: skip
"""Options of the page, in order; the others need ROS, a solver, or files."""

_FIELDS = {one.name: one for kind in Scenario.PARTS.values() for one in fields(kind)}

_EMPTY = Path(str(resources.files('setcmas_ctrl') / 'templates' / 'control_law.py'))
_COMMANDS = re.compile(r'\nCommands\n(    .*\n)+"""')
"""The end of an exercise's docstring: a page has no terminal to type them in."""


def catalogue(names: Sequence[str] = (), rubrics: Sequence[Path] = ()) -> dict[str, Any]:
    """Return what a page offers, and with what it begins, as JSON has it.

    Args:
        names: Exercises; all shipped ones, and the laws that solve them, without names and
            rubrics.
        rubrics: Rubrics; only their shown parts are described.

    Raises:
        SetcmasError: An exercise is unknown, or a rubric has a mistake or the name of another.
    """
    stems = [one.stem for one in rubrics]
    if twice := sorted({one for one in stems if stems.count(one) > 1}):
        raise SetcmasError(f"two files are named '{twice[0]}'; rename one")
    is_chosen = bool(names or rubrics)
    marked = [
        ('exercise', name, rubric_of_exercise(name).shown())
        for name in (names if is_chosen else _exercises_with_rubrics())
    ]
    marked += [('rubric', one.stem, read_rubric(one).shown()) for one in rubrics]
    exercises = [_exercise(*one) for one in marked]
    solved = {rubric.exercise for _, _, rubric in marked} if is_chosen else ()
    laws = [
        _source(f'law:{name}', 'Laws', name, name, ALGORITHMS.file(name))
        for name in _names(ALGORITHMS)
        if name not in solved
    ]
    return {
        'first': exercises[0]['key'] if is_chosen else 'law:consensus',
        'sources': [
            _source('template:', 'New', 'an empty law', 'law', _EMPTY),
            *exercises,
            *laws,
        ],
        'options': [_option(_FIELDS[name]) for name in _OFFERED],
    }


def _exercises_with_rubrics() -> list[str]:
    names = _names(EXERCISES)
    return [name for name in names if EXERCISES.file(name).with_suffix('.yaml').is_file()]


def _names(group: ScriptGroup) -> list[str]:
    """Return the names of the scripts of a group, one for each script."""
    names: dict[Path, str] = {}
    for name in group.plugins():
        names.setdefault(group.file(name), name)
    return [*names.values()]


def _source(key: str, group: str, label: str, name: str, file: Path) -> dict[str, Any]:
    """Return a text to start from, and the settings in it."""
    return {
        'key': key,
        'group': group,
        'label': label,
        'name': f'my_{name}.py',
        'text': _COMMANDS.sub('"""', file.read_text(encoding='utf-8'), count=1),
        'settings': [one for one in names_to_set(file) if one.isupper()],  # others are state
    }


def _exercise(kind: str, name: str, rubric: Rubric) -> dict[str, Any]:
    file = EXERCISES.file(rubric.exercise) if rubric.exercise else _EMPTY
    label = f'{rubric.title} ({rubric.max_score:g} points)'
    source = _source(f'{kind}:{name}', 'Exercises', label, rubric.exercise or name, file)
    return source | {'checks': {kind: name}, 'function': rubric.function.value}


def _option(one: Field[Any]) -> dict[str, Any]:
    option: Option = one.metadata['option']
    kind = option.kind
    default = plain(default_of(one))
    return {
        'name': one.name,
        'help': option.help,
        'must_be': kind.must_be,
        'input': _input(option),
        'default': None if default == math.inf else default,  # as JSON has no limit
        'default_text': option.default_text,
        'unit': getattr(kind, 'unit', ''),
        'choices': [*(MODELS.plugins() if one.name == 'model' else kind.choices)],
    }


def _input(option: Option) -> str:
    if option.is_switch:
        return 'switch'
    if option.is_several:
        return 'several'
    if isinstance(option.kind, (Number, Whole)):
        return 'number'
    return 'choice' if option.kind.choices else 'text'
