"""Exercise of a script: which one it solves, its solution, and whether it is filled in."""

from __future__ import annotations

import ast
from pathlib import Path

from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES, plain_values
from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function

FUNCTIONS = Function.CONTROL, Function.CONDITION, Function.SI_TO_UNI
"""The functions that students fill in: a control law, a triggering condition, or si_to_uni."""

UNREADABLE = (SyntaxError, ValueError, RecursionError, MemoryError)
"""Errors of `ast.parse` for text that is not Python, or is nested too deeply."""


def exercise_of(script: Path) -> str:
    """Return the exercise that a script solves, '' if none; raise SetcmasError if unreadable.

    The script names it in a line such as exercise = 'consensus', or by its file name.
    """
    name = plain_values(script).get('exercise', script.stem)
    return name if isinstance(name, str) and name in EXERCISES else ''


def solution_of(exercise: str, function: Function) -> Path | None:
    """Return the solution that comes with an exercise; None if there is none.

    For a law, it is the built-in law of the same name; for a condition or si_to_uni, it is
    NAME_solution.py in the folder of the exercise.
    """
    if function is Function.CONTROL:
        return ALGORITHMS.file(exercise) if exercise in ALGORITHMS else None
    file = EXERCISES.file(exercise).with_name(f'{exercise}_solution.py')
    return file if file.is_file() else None


def is_unfilled(script: Path, exercise: str = '') -> bool:
    """Return whether a script's maths is still that of the empty exercise.

    Only these functions count, without comments and docstrings. Errors of a script that cannot
    be read are reported when it is loaded. The script names the exercise by default.
    """
    try:
        name = exercise or exercise_of(script)
        return bool(name) and same_functions(
            script.read_bytes(), EXERCISES.file(name).read_bytes()
        )
    except (OSError, SetcmasError):
        return False


def same_functions(source: bytes, exercise: bytes) -> bool:
    """Return whether a script has the functions of an empty exercise, unchanged."""
    try:
        return _functions(source) == _functions(exercise) != []
    except UNREADABLE:
        return False


def unfilled_note(script: Path) -> str:
    """Return a note that a script is not filled in yet; '' if it is."""
    if not is_unfilled(script):
        return ''
    name = exercise_of(script)
    if script == EXERCISES.file(name):
        copy = f'setcmas new my_{name} --from {name} --exercise'
        return f'exercise {name} is not filled in yet; copy it with {copy}'
    return f'{script.name} is not filled in yet; replace the parts marked TODO'


def _functions(source: bytes) -> list[str]:
    tree = ast.parse(source)
    nodes = (node for node in tree.body if isinstance(node, ast.FunctionDef))
    names = [one.value for one in FUNCTIONS]
    functions = [node for node in nodes if node.name in names]
    for function in functions:
        if ast.get_docstring(function) is not None:
            del function.body[0]
    return [ast.dump(function) for function in functions]
