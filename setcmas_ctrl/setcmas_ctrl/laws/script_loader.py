"""Loader of control scripts: compiles and runs them, in a fresh module per robot."""

from __future__ import annotations

import ast
import contextlib
import linecache
import sys
import tokenize
import types
import warnings
from collections.abc import Iterator
from importlib.machinery import FileFinder
from pathlib import Path
from typing import Any

from setcmas_ctrl.laws.script_errors import StopCall, describe_failure, scripts_own
from setcmas_ctrl.laws.script_function import (
    CONTROL,
    NOTED,
    check_defines,
    literals,
    note_returns,
    noted,
)
from setcmas_ctrl.laws.script_imports import ScriptImports
from setcmas_ctrl.laws.script_settings import (
    CALL,
    Settings,
    apply_settings,
    converted,
    plain_names,
)
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.plugins import ScriptGroup

ALGORITHMS = ScriptGroup('setcmas.algorithms', 'control law')
EXERCISES = ScriptGroup('setcmas.exercises', 'exercise')
"""Scripts whose maths students fill in."""

CONDITIONS = ScriptGroup('setcmas.conditions', 'triggering condition')

_syntax_warnings: dict[Path, list[str]] = {}  # not shown yet, by script
_compiled: dict[tuple[Path, str, str, str], types.CodeType] = {}  # by path, source and more
_MOST_COMPILED = 500  # more than one diagnosis of a mistake loads, again for each robot


def names_to_set(path: Path) -> list[str]:
    """Return the module-level names of a valid script that `--set` may change."""
    return plain_names(_read(path), path.name)


def compile_script(
    path: Path, expected: str = CONTROL, settings: Settings | None = None
) -> types.CodeType:
    """Compile a script that defines the expected function, or raise SetcmasError; do not run it.

    The settings replace values of the script (`--set`).
    """
    source = _read(path)
    key = path, source, expected, repr(settings)
    if key not in _compiled:
        if len(_compiled) >= _MOST_COMPILED:
            _compiled.clear()
        _compiled[key] = _compile(path, source, expected, settings)
    return _compiled[key]


def _compile(path: Path, source: str, expected: str, settings: Settings | None) -> types.CodeType:
    with _reported_errors(path), warnings.catch_warnings(record=True) as found:
        warnings.simplefilter('always', SyntaxWarning)
        tree = ast.parse(source, str(path))
        compile(tree, str(path), 'exec')
    check_defines(tree, expected, path)
    if settings:
        apply_settings(tree, source, settings, path.name)
    note_returns(tree)
    code = compile(tree, str(path), 'exec')
    _syntax_warnings[path] = [f'{path.name}, line {each.lineno}: {each.message}' for each in found]
    return code


@contextlib.contextmanager
def _reported_errors(path: Path) -> Iterator[None]:
    """Raise SetcmasError with the line for what Python cannot read in a script."""
    try:
        yield
    except (SyntaxError, ValueError) as error:
        raise SetcmasError(describe_failure(error, path)) from error
    except (RecursionError, MemoryError) as error:
        raise SetcmasError(
            f'{path.name}: an expression is nested too deeply for Python ({type(error).__name__})'
        ) from error


def parsed(path: Path) -> ast.Module:
    """Return the tree of a script, or raise SetcmasError with the line of a mistake."""
    source = _read(path)
    with _reported_errors(path), warnings.catch_warnings():
        warnings.simplefilter('ignore', SyntaxWarning)  # they are shown when it is loaded
        return ast.parse(source, str(path))


def plain_values(path: Path) -> dict[str, Any]:
    """Return the plain values of a script's top level, or raise SetcmasError; do not run it."""
    return dict(literals(parsed(path)))


def _read(path: Path) -> str:
    """Return the source of a script; errors quote it even after an edit of the file."""
    try:
        with tokenize.open(path) as file:
            source = file.read()
        lines = source.splitlines(keepends=True)
        linecache.cache[str(path)] = (len(source), None, lines, str(path))
        return source
    except OSError as error:
        raise SetcmasError(f"script '{path}' cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise SetcmasError(
            f'{path.name} is not encoded in {error.encoding} '
            f'(byte {error.object[error.start]:#x}); save it as UTF-8, or name its encoding in '
            'its first line, such as # -*- coding: latin-1 -*-'
        ) from error
    except SyntaxError as error:  # neither UTF-8 nor another known encoding
        reason = error.msg.partition(' for ')[0]
        raise SetcmasError(f'{path.name} has an {reason}; save it as UTF-8') from error


def load_script(
    path: Path, robot: int, expected: str = CONTROL, settings: Settings | None = None
) -> types.ModuleType:
    """Run a script in a fresh module for a robot; return the module, or raise SetcmasError.

    Helper modules in its folder are fresh for every robot too, because scripts keep their state in
    module globals. Arguments as for `compile_script`.
    """
    settings = settings or {}
    code = compile_script(path, expected, settings)
    for warning in _syntax_warnings.pop(path, ()):  # once for all robots
        print(f'warning: {warning}', file=sys.stderr, flush=True)
    module = _fresh_module(path, robot, settings)
    try:
        exec(code, module.__dict__)
    except (StopCall, SetcmasError):
        raise
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt) and not scripts_own(error):
            raise
        # If it fails only for a later robot, the message names the robot.
        name = f'{robot_name(robot)}: ' if robot > 1 else ''
        raise SetcmasError(f'{name}{describe_failure(error, path)}') from error
    for name in settings:
        if name not in vars(module):
            raise SetcmasError(f"setting {name}: {path.name} has no module-level name '{name}'")
    return module


def _fresh_module(path: Path, robot: int, settings: Settings) -> types.ModuleType:
    """Return an empty module for a robot's script, with its own imports."""

    def setting(name: str, own: Any) -> Any:
        return converted(name, own, settings[name], path.name)

    module = types.ModuleType(f'{path.stem}_tb3_{robot}')
    module.__file__ = str(path)
    imports = ScriptImports(path.parent, robot)
    imports.builtins |= {CALL: setting, NOTED: noted}
    vars(module)['__builtins__'] = imports.builtins
    sys.modules[module.__name__] = module
    folder = str(path.parent)
    if folder not in sys.path:
        sys.path.append(folder)  # for importlib.import_module and similar
    for place, finder in list(sys.path_importer_cache.items()):
        if place.startswith(folder) and isinstance(finder, FileFinder):
            finder.invalidate_caches()  # a helper module may be new
    return module
