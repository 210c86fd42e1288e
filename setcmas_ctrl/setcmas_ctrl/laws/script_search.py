"""Search of scripts: by path, in the current folder, and among those of installed packages."""

from __future__ import annotations

import ast
import contextlib
from collections.abc import Sequence
from pathlib import Path

from setcmas_ctrl.laws.script_function import CONTROL, check_defines
from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES, parsed
from setcmas_simu.errors import SetcmasError, did_you_mean
from setcmas_simu.plugins import ScriptGroup

_MOST_NAMES = 10


def find_script(name: str, exercise: bool = False) -> Path:
    """Return the script for `--algo NAME`, or raise SetcmasError with similar names.

    In this order: a path to a file; NAME.py in the current folder; with `exercise`, an exercise;
    a control law, built in or of a plugin.
    """
    for path in (Path(name), Path(f'{name}.py')):
        with contextlib.suppress(OSError):  # such as a name that is too long
            if path.is_file():
                if path.suffix == '.ipynb':
                    raise SetcmasError(
                        f"'{path.name}' is a notebook; start its cell with "
                        f'`%%writefile {path.stem}.py` and use --algo {path.stem}.py'
                    )
                return path.resolve()
    groups = {'exercises': EXERCISES} if exercise else {}
    groups['control laws'] = ALGORITHMS
    for group in groups.values():
        if name in group:
            return group.file(name)
    names = {title: list(group.plugins()) for title, group in groups.items()}
    names['in this folder'] = [path.stem for path in scripts_in(Path.cwd()) if _may_be_law(path)]
    known = list(dict.fromkeys(stem for stems in names.values() for stem in stems))
    lists = '; '.join(f'{title}: {_first(stems)}' for title, stems in names.items())
    hint = did_you_mean(Path(name).stem, known, 3)
    raise SetcmasError(f"control script '{name}' not found; {lists}{hint}")


def find_script_of(option: str, name: str, function: str, *groups: ScriptGroup) -> Path:
    """Return the script that another option than `--algo` names, or raise SetcmasError.

    In this order: a path to a file; NAME.py in the current folder; a script of one of the groups.
    The function that it must define is for the message.
    """
    for path in (Path(name), Path(f'{name}.py')):
        with contextlib.suppress(OSError):
            if path.is_file():
                return path.resolve()
    for group in groups:
        if name in group:
            return group.file(name)
    known = [one for group in groups for one in group.plugins()]
    others = f', or one of {", ".join(known)}{did_you_mean(name, known)}' if known else ''
    raise SetcmasError(
        f"script '{name}' of {option} was not found; it must be a path, or the name of a script "
        f'in this folder with a function {function}{others}'
    )


def _first(names: Sequence[str]) -> str:
    shown = [*names[:_MOST_NAMES], *(['...'] if len(names) > _MOST_NAMES else [])]
    return ', '.join(shown) or 'none'


def scripts_in(folder: Path) -> list[Path]:
    """Return the scripts in a folder, sorted by name."""
    paths = (path for path in folder.glob('*.py') if not path.name.startswith('_'))
    return sorted(path for path in paths if path.is_file())


def _may_be_law(path: Path) -> bool:
    """Return whether a script defines a control law, or cannot be parsed."""
    try:
        tree = parsed(path)
    except SetcmasError:
        return True
    try:
        check_defines(tree, CONTROL, path)
    except SetcmasError:
        return False
    return True


_LISTED = {'control', 'ctc', 'si_to_uni'}
"""A listed script defines one of these: a law, a triggering condition, or a conversion."""


def summary_of(path: Path) -> str | None:
    """Return the first line of a script's docstring; None if it is no control script."""
    try:
        tree = parsed(path)
    except SetcmasError as error:
        message, *_ = str(error).splitlines()
        return f'(cannot be read: {message})'
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    if not functions & _LISTED:
        return None
    return (ast.get_docstring(tree) or '').partition('\n')[0]
