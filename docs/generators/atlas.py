"""Writes docs/atlas.md and its figures, from runs of its own.

python docs/generators/atlas.py     takes about half a minute
"""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use('Agg')

from generate import DOCS

from setcmas_ctrl.scripts.loader import ALGORITHMS
from setcmas_tools import Run, simulate
from setcmas_tools.measures.metrics import fleet_lines
from setcmas_tools.measures.predicted_metrics import Comparison

THEORY: dict[str, Any] = {
    'model': 'omnidirectional',
    'vnom': 50.0,
    'rate': 25.0,
    'robot_rate': 25.0,
}
"""Options of robots of the theory: points without limits, and laws called often."""

EXACT = {**THEORY, 'set': {'SLOW': 0}}
"""Also without a dead band."""

PLOT_DPI = 110
CHAPTERS: dict[str, list[tuple[str, dict[str, Any]]]] = {
    'Consensus': [
        ('consensus', {'nb_robots': 8, 'duration': 60.0, 'graph': 'star', **THEORY}),
        (
            'laplacian_consensus',
            {'nb_robots': 4, 'duration': 40.0, 'graph': 'path', **EXACT},
        ),
        ('finite_time_consensus', {'nb_robots': 8, 'duration': 60.0, 'graph': 'ring', **THEORY}),
        ('resilient_consensus', {'nb_robots': 8, 'duration': 60.0, **THEORY}),
        ('leader_election', {'nb_robots': 8, 'duration': 20.0, 'graph': 'path'}),
    ],
    'Rendezvous, containment and pursuit': [
        ('rendezvous', {'nb_robots': 8, 'duration': 40.0, 'range': 6.0, **THEORY, 'vnom': 0.5}),
        ('containment', {'nb_robots': 8, 'duration': 60.0, 'graph': 'ring', **EXACT}),
        ('cyclic_pursuit', {'nb_robots': 5, 'duration': 100.0, **THEORY}),
    ],
    'From the ROS 1 stack': [
        ('nav_wp', {'nb_robots': 1, 'duration': 60.0}),
        ('traj_tracking', {'nb_robots': 1, 'duration': 60.0}),
        ('leader_follower_formation', {'nb_robots': 5, 'duration': 60.0}),
        ('leader_follower_distance_formation', {'nb_robots': 3, 'duration': 60.0}),
    ],
}
HEAD = """# Atlas of laws

The built-in control laws: formula, source, an example run, and what theory predicts for that run.
Copy one with `setcmas new my_law --from NAME`. The numbers were measured in the runs shown;
`docs/generators/atlas.py` makes this page.
"""


def main() -> None:
    """Write the page and a figure for each law."""
    page = [HEAD]
    for chapter, entries in CHAPTERS.items():
        page.append(f'## {chapter}\n')
        page += [entry(name, options) for name, options in entries]
    (DOCS / 'atlas.md').write_text('\n'.join(page))


def entry(name: str, options: dict[str, Any]) -> str:
    """Return the section of a law; write its figure."""
    run = simulate(name, warn=print, **options)
    figure = run.plot('trajectories')
    figure.savefig(DOCS / 'pictures' / f'atlas_{name}.png', dpi=PLOT_DPI)
    summary, _, rest = docstring(ALGORITHMS.file(name)).partition('\n\n')
    title, _, does = ' '.join(summary.split()).partition(': ')
    words = ' '.join(f'--{key.replace("_", "-")} {_typed(v)}' for key, v in options.items())
    return '\n'.join(
        [
            f'### {title}\n',
            f'`{name}`: {does}\n',
            indented_as_code(rest),
            f'![Paths of the robots](pictures/atlas_{name}.png){{ width="480" }}\n',
            f'```sh\nsetcmas offline --algo {name} {words}\n```\n',
            *theory(run),
        ]
    )


def _typed(value: object) -> str:
    if isinstance(value, dict):
        return ' '.join(f'{name}={_typed(one)}' for name, one in value.items())
    return f'{value:g}' if isinstance(value, float) else str(value)


def docstring(path: Path) -> str:
    """Return the docstring of a script."""
    return ast.get_docstring(ast.parse(path.read_text())) or ''


def indented_as_code(text: str) -> str:
    """Return a text whose indented lines, formulas, are blocks of code; lines are joined."""
    blocks = []
    for block in text.split('\n\n'):
        if block.startswith('    '):
            lines = '\n'.join(line.removeprefix('    ') for line in block.splitlines())
            blocks.append(f'```text\n{lines}\n```')
        else:
            blocks.append(re.sub(r' (Source: )', r'\n\n\1', ' '.join(block.split())))
    return '\n\n'.join(blocks) + '\n'


def theory(run: Run) -> list[str]:
    """Return what `setcmas metrics` prints of the prediction, or of the law's task."""
    metrics = run.metrics()
    found = metrics.get('prediction')
    lines = found.lines() if isinstance(found, Comparison) else fleet_lines(metrics.parts)
    return ['```text', *lines, '```', '']


if __name__ == '__main__':
    main()
