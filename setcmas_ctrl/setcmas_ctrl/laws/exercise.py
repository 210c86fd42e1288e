"""Exercise of a script: which one it solves, whether it is filled in, and how one is made."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from setcmas_ctrl.laws.script_loader import EXERCISES, plain_values
from setcmas_simu.errors import SetcmasError, file_errors

_FILLED_IN = ('control', 'ctc', 'si_to_uni')
"""The functions that students fill in."""


def exercise_of(script: Path) -> str:
    """Return the exercise that a script solves, '' if none; raise SetcmasError if unreadable.

    The script names it in a line such as exercise = 'consensus', or by its file name.
    """
    name = plain_values(script).get('exercise', script.stem)
    return name if isinstance(name, str) and name in EXERCISES else ''


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
    except (SyntaxError, ValueError, RecursionError, MemoryError):
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
    functions = [node for node in nodes if node.name in _FILLED_IN]
    for function in functions:
        if ast.get_docstring(function) is not None:
            del function.body[0]
    return [ast.dump(function) for function in functions]


BEGIN, END = '# BEGIN SOLUTION', '# END SOLUTION'
"""Comments around what students are to write, as in nbgrader."""

_MARKED = re.compile(
    rf'^([ \t]*)#*{BEGIN}[: \t]*(.*)\n(?:(?!.*{BEGIN}).*\n)*?[ \t]*#*{END}.*$', re.MULTILINE
)
_RUBRIC = """\
# A draft of how setcmas check and setcmas grade mark this exercise; docs/grading.md explains it.
title: {title}
function: {function}
solution: {solution}

scenarios:
  - name: five robots
    nb_robots: 5
    duration: 40
    criteria:
      - name: the robots end where those of the solution end
        metric: end_error
        at_most: 0.15      # full points up to here (m)
        none_at: 1         # none from here on
        points: 4
        # hint: what to look at, whatever the mistake is
      - name: the robots take the paths of the solution
        metric: path_distance
        needs: the robots end where those of the solution end
        at_most: 0.15
        none_at: 1
        points: 3

  - name: three robots from random places
    hidden: true           # students see only its points
    nb_robots: 3
    duration: 40
    random_poses: auto
    seed: 2
    criteria:
      - name: the results are those of the solution
        metric: answer_error
        at_most: 0.05
        none_at: 0.8
        points: 3
"""


def cut_exercise(solution: Path) -> str:
    """Return a solution with a TODO in place of each marked part.

    The TODO has the text that follows the first comment of the part.

    Raises:
        SetcmasError: It cannot be read, has no marked part, or is no Python without them.
    """
    with file_errors(f"'{solution}' cannot be read"):
        source = solution.read_text(encoding='utf-8')
    text, count = _MARKED.subn(_todo, source)
    if not count or BEGIN in text or END in text:
        raise SetcmasError(
            f"'{solution}' must have each part that students are to write between the lines "
            f"'{BEGIN}' and '{END}'"
        )
    try:
        ast.parse(text)
    except SyntaxError as error:
        raise SetcmasError(
            f"'{solution}' is no Python without its marked parts: {error.msg} at "
            f"'{(error.text or '').strip()}'; mark whole statements"
        ) from error
    return text


def _todo(part: re.Match[str]) -> str:
    return f'{part[1]}# TODO: {part[2].strip() or "write this part"}\n{part[1]}pass'


def draft_rubric(solution: Path, title: str) -> str:
    """Return the draft of a rubric for an exercise that was cut from a solution."""
    found = re.search(
        r'^def (ctc|si_to_uni)\b', solution.read_text(encoding='utf-8'), re.MULTILINE
    )
    function = found[1] if found else 'control'
    place = solution.resolve()
    if place.is_relative_to(Path.cwd()):
        place = place.relative_to(Path.cwd())
    return _RUBRIC.format(title=title, function=function, solution=place.as_posix())
