"""Exercise of one's own: a solution without its marked parts, and a draft of its rubric."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from setcmas_simu.errors import SetcmasError, file_errors

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
