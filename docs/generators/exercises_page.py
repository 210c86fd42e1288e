"""The page of exercises: what each asks for, its formula, commands and points."""

from __future__ import annotations

import ast
import textwrap
from pathlib import Path

from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES
from setcmas_tools.grade.rubric import rubric_of_exercise

_HEAD = """# Exercises

Each is a script with blanks: `setcmas new my_law --from NAME --exercise` copies it, and
`setcmas check my_law` marks it, with one hint at a time. Until you fill the blanks in, the robots
stand still, without an error. The model solution is the built-in law of the same name; that of
`point_ahead` is `setcmas_ctrl/exercises/point_ahead_solution.py`. Lecturers
[grade a class](grading.md) with the same rubrics. The [course](course/index.md) uses some of them.
"""
_GROUPS: dict[str, tuple[str, ...]] = {
    'Waypoints, tracking and formations': (
        'nav_wp', 'traj_tracking', 'point_ahead', 'leader_follower_formation',
        'distance_formation', 'bearing_formation',
    ),
    'Consensus': (
        'consensus', 'laplacian_consensus', 'finite_time_consensus', 'resilient_consensus',
        'rendezvous', 'containment', 'cyclic_pursuit', 'coverage',
    ),
    'Messages and memory': (
        'ctc', 'leader_election', 'velocity_alignment', 'second_order_consensus', 'kuramoto',
        'distributed_optimisation', 'dynamic_average',
    ),
}  # fmt: skip


def text() -> str:
    """Return the page; exercises that belong to no group come last."""
    names = sorted({EXERCISES.file(name).stem for name in EXERCISES.plugins()})
    grouped = {name for group in _GROUPS.values() for name in group}
    others = [name for name in names if name not in grouped]
    groups = {**_GROUPS, **({'Others': tuple(others)} if others else {})}
    rows = [_row(name) for group in groups.values() for name in group]
    sections = [
        '\n'.join([f'## {title}\n', *map(_section, group)]) for title, group in groups.items()
    ]
    table = ['| exercise | what it asks for | points | scenarios |', '|---|---|---|---|', *rows]
    return '\n'.join([_HEAD, *table, '', *sections])


def _row(name: str) -> str:
    title, asks = _title(name)
    rubric = rubric_of_exercise(name)
    return f'| [{title}](#{name}) | {asks} | {rubric.max_score:g} | {len(rubric.scenarios)} |'


def _section(name: str) -> str:
    """Return the section of an exercise, from its docstring."""
    title, _ = _title(name)
    parts = dict(_parts(_docstring(name)))
    law = ALGORITHMS.plugins().get(name)
    solved = f' The solution is the law `{name}` of the [atlas](atlas.md).' if law else ''
    observe = parts.get('What to observe', '')
    lines = [f'### {title} {{ #{name} }}\n', ' '.join(parts['Goal'].split()) + solved + '\n']
    formula = next(body for head, body in parts.items() if head.startswith('Formula'))
    lines += [f'```text\n{formula}\n```\n', 'What to observe:\n', f'{observe}\n']
    return '\n'.join([*lines, f'```sh\n{_commands(parts["Commands"])}\n```\n'])


def _commands(text: str) -> str:
    """Return commands without what they do."""
    return '\n'.join(line.split('    ')[0].rstrip() for line in text.splitlines() if line.strip())


def _docstring(name: str) -> str:
    return ast.get_docstring(ast.parse(Path(EXERCISES.file(name)).read_text())) or ''


def _title(name: str) -> tuple[str, str]:
    """Return the title of an exercise, and what it asks for."""
    summary = ' '.join(_docstring(name).partition('\n\n')[0].split()).removeprefix('Exercise: ')
    title, _, asks = summary.partition('. ')
    return title[0].upper() + title[1:].rstrip('.'), asks


def _parts(docstring: str) -> list[tuple[str, str]]:
    """Return the parts of a docstring: heading and text."""
    parts: list[tuple[str, list[str]]] = []
    for line in docstring.splitlines():
        if line and not line.startswith(' '):
            parts.append((line, []))
        elif parts:
            parts[-1][1].append(line)
    return [(head, textwrap.dedent('\n'.join(body)).strip('\n')) for head, body in parts]
