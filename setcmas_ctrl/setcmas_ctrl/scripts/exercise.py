"""Exercise that a script is a copy of, and whether its maths is filled in yet."""

from __future__ import annotations

import ast
from pathlib import Path

from setcmas_ctrl.scripts.loader import EXERCISES
from setcmas_ctrl.scripts.output import plain_values
from setcmas_simu.errors import SetcmasError

_FILLED_IN = ('control', 'ctc')
"""The functions that exercises leave to fill in."""


def exercise_of(script: Path) -> str:
    """Return the name of the exercise that a script is for; empty if it is for none.

    The script says so in a line such as exercise = 'consensus', or by its own name.

    Raises:
        SetcmasError: The script cannot be read.
    """
    told = plain_values(script).get('exercise', script.stem)
    return told if isinstance(told, str) and told in EXERCISES else ''


def is_unfilled(script: Path, exercise: str = '') -> bool:
    """Return whether the maths of a script is still that of the exercise.

    Comments, docstrings and everything outside of `control` and `ctc` do not count. A script that
    cannot be read is told of where it is loaded.

    Args:
        script: The script.
        exercise: The exercise that it may be a copy of; what it says itself by default.
    """
    try:
        name = exercise or exercise_of(script)
        return bool(name) and _functions(script) == _functions(EXERCISES.file(name)) != []
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError, SetcmasError):
        return False


def unfilled_note(script: Path) -> str:
    """Return a line that says that a script is not filled in yet; empty if it is."""
    if not is_unfilled(script):
        return ''
    name = exercise_of(script)
    if script == EXERCISES.file(name):
        copy = f'setcmas new my_{name} --from {name} --exercise'
        return f'exercise {name} is not filled in yet; {copy} writes a copy to do that in'
    return f'{script.name} is not filled in yet; replace what is marked TODO'


def _functions(script: Path) -> list[str]:
    tree = ast.parse(script.read_bytes())
    found = [one for one in tree.body if isinstance(one, ast.FunctionDef)]
    return [_dumped(one) for one in found if one.name in _FILLED_IN]


def _dumped(function: ast.FunctionDef) -> str:
    if ast.get_docstring(function) is not None:
        function.body = function.body[1:]
    return ast.dump(function)
