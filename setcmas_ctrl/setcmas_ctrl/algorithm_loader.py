"""Finds control scripts and loads them, a fresh module for every robot."""

from __future__ import annotations

import ast
import contextlib
import difflib
import inspect
import linecache
import sys
import tokenize
import types
from collections.abc import Callable
from importlib import resources
from pathlib import Path
from typing import Any

from setcmas_ctrl import rviz_marker, rviz_marker_array
from setcmas_ctrl.script_messages import describe_failure
from setcmas_simu.errors import SetcmasError

Control = Callable[..., Any]

ALIASES = {'wp_nav': 'nav_wp'}
"""Other names of built-in control laws."""

_EXPECTED = 'control(robotNo, nbRobots, poses, t)'


def builtin_folder() -> Path:
    """Return the folder of the built-in control laws."""
    return Path(str(resources.files('setcmas_ctrl') / 'algorithms'))


def scripts_in(folder: Path) -> list[Path]:
    """Return the scripts in a folder, sorted by name."""
    return sorted(path for path in folder.glob('*.py') if not path.name.startswith('_'))


def find_script(name: str) -> Path:
    """Return the script that `--algo NAME` means.

    In this order: a path to a file; NAME.py in the current folder; a built-in control law.

    Raises:
        SetcmasError: There is none; the message offers the nearest names.
    """
    builtin = ALIASES.get(name, name).replace('-', '_')
    candidates = (Path(name), Path(f'{name}.py'), builtin_folder() / f'{builtin}.py')
    for path in candidates:
        with contextlib.suppress(OSError):  # such as a name too long to be one
            if path.is_file():
                return path.resolve()
    builtins = [path.stem for path in scripts_in(builtin_folder())]
    own = [path.stem for path in scripts_in(Path.cwd())]
    near = difflib.get_close_matches(Path(name).stem, [*builtins, *own, *ALIASES], n=3)
    hint = f'did you mean {" or ".join(near)}? ' if near else ''
    raise SetcmasError(
        f"control script '{name}' was not found: {hint}built-in are {', '.join(builtins)}; "
        f'scripts in this folder: {", ".join(own) or "none"}'
    )


def compile_script(path: Path) -> types.CodeType:
    """Compile a script without running it, and see that it gives `control` a meaning.

    Raises:
        SetcmasError: It cannot be read, has a syntax error, or has no `control`.
    """
    try:
        with tokenize.open(path) as file:
            source = file.read()
        # Errors quote what was run, even when the file has been edited meanwhile.
        lines = source.splitlines(keepends=True)
        linecache.cache[str(path)] = (len(source), None, lines, str(path))
        tree = ast.parse(source, str(path))
        code = compile(tree, str(path), 'exec')
    except OSError as error:
        raise SetcmasError(f"control script '{path}' cannot be read: {error.strerror}") from error
    except (SyntaxError, ValueError) as error:
        raise SetcmasError(describe_failure(error, path)) from error
    if not _may_define_control(tree):
        raise SetcmasError(f'{path.name} has no function control; expected is {_EXPECTED}')
    return code


def load_control(path: Path, robot: int) -> Control:
    """Run a script in a fresh module for one robot and return its `control`.

    Raises:
        SetcmasError: The script fails while it is loaded, or `control` does not take four
            arguments.
    """
    return checked_control(vars(load_script(path, robot)).get('control'), path)


def load_script(path: Path, robot: int) -> types.ModuleType:
    """Run a script in a fresh module for one robot and return the module.

    Helper modules beside the script that it imports at its top are fresh for every robot too,
    because scripts keep their state in module globals; those that a function imports later are
    shared by the robots of a process.

    Raises:
        SetcmasError: The script cannot be read, or fails while it is loaded.
    """
    code = compile_script(path)
    module = types.ModuleType(f'{path.stem}_tb3_{robot}')
    module.__file__ = str(path)
    sys.modules[module.__name__] = module
    sys.modules['rviz_marker'] = rviz_marker
    sys.modules['rviz_marker_array'] = rviz_marker_array
    known = set(sys.modules)
    folder = str(path.parent)
    sys.path.insert(0, folder)
    try:
        exec(code, module.__dict__)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise SetcmasError(describe_failure(error, path)) from error
    finally:
        sys.path.remove(folder)
        if folder not in sys.path:
            sys.path.append(folder)  # for imports inside functions, behind everything else
        _forget_helpers(path.parent, known)
    return module


def _forget_helpers(folder: Path, known: set[str]) -> None:
    for name in set(sys.modules) - known:
        file = getattr(sys.modules[name], '__file__', None)
        if file and folder in Path(file).parents:
            del sys.modules[name]


def checked_control(control: Any, path: Path) -> Control:
    """Return a script's `control` if it can be called with four arguments.

    Raises:
        SetcmasError: It cannot.
    """
    if not callable(control):
        raise SetcmasError(f'{path.name} has no function control; expected is {_EXPECTED}')
    try:
        signature = inspect.signature(control)
    except (TypeError, ValueError):  # some callables written in C tell nothing of themselves
        return control  # type: ignore[no-any-return]
    try:
        signature.bind(1, 1, None, 0.0)
    except TypeError as error:
        raise SetcmasError(
            f'{path.name}: control{signature} does not take four arguments; '
            f'expected is {_EXPECTED}'
        ) from error
    return control  # type: ignore[no-any-return]


def _may_define_control(tree: ast.Module) -> bool:
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and node.name == 'control':
            return True
        if isinstance(node, ast.Name) and node.id == 'control' and isinstance(node.ctx, ast.Store):
            return True
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            names = {alias.asname or alias.name for alias in node.names}
            if names & {'control', '*'}:
                return True
    return False
