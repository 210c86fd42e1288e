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

from setcmas_ctrl.laws.script_loader import ALGORITHMS
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
        ('leader_election', {'nb_robots': 8, 'duration': 60.0, 'graph': 'path'}),
        ('distributed_optimisation', {'nb_robots': 6, 'duration': 90.0, 'graph': 'ring', **EXACT}),
        ('dynamic_average', {'nb_robots': 5, 'duration': 60.0, 'graph': 'ring', **EXACT}),
    ],
    'Rendezvous, containment and pursuit': [
        ('rendezvous', {'nb_robots': 8, 'duration': 40.0, 'range': 6.0, **THEORY, 'vnom': 0.5}),
        ('containment', {'nb_robots': 8, 'duration': 60.0, 'graph': 'ring', **EXACT}),
        ('cyclic_pursuit', {'nb_robots': 5, 'duration': 100.0, **THEORY}),
    ],
    'Velocities and phases': [
        ('velocity_alignment', {'nb_robots': 8, 'duration': 40.0, 'graph': 'ring', **THEORY}),
        (
            'second_order_consensus',
            {'nb_robots': 5, 'duration': 100.0, 'graph': 'directed_ring', **EXACT},
        ),
        (
            'kuramoto',
            {
                'nb_robots': 6,
                'duration': 40.0,
                'random_poses': 'box=8x5,distance=2.5',
                'set': {'DW': 0},
            },
        ),
    ],
    'Formations and coverage': [
        (
            'distance_formation',
            {'nb_robots': 5, 'duration': 20.0, 'random_poses': 'box=8x8,distance=1.5', **EXACT},
        ),
        ('bearing_formation', {'nb_robots': 5, 'duration': 60.0, **EXACT}),
        (
            'coverage',
            {'nb_robots': 8, 'duration': 60.0, 'random_poses': 'box=4x4,distance=0.8', **THEORY},
        ),
    ],
    'From the ROS 1 stack': [
        ('nav_wp', {'nb_robots': 1, 'duration': 60.0}),
        ('traj_tracking', {'nb_robots': 1, 'duration': 60.0}),
        ('leader_follower_formation', {'nb_robots': 5, 'duration': 60.0}),
        ('leader_follower_distance_formation', {'nb_robots': 3, 'duration': 60.0}),
    ],
}
SCENARIOS: list[tuple[str, str, dict[str, Any]]] = [
    (
        'Directed graph',
        "If some robot reaches all others, they meet at w' p(0) with w' L = 0 and w' 1 = 1, which "
        'is their mean if and only if each robot sends with the same sum of weights as it '
        'receives.\n\nSource: Olfati-Saber and Murray, Consensus problems in networks of agents '
        'with switching topology and time-delays, IEEE Transactions on Automatic Control 49(9), '
        '2004; Ren and Beard, Consensus seeking in multiagent systems under dynamically changing '
        'interaction topologies, IEEE Transactions on Automatic Control 50(5), 2005.',
        {'nb_robots': 4, 'duration': 40.0, 'graph': 'docs/studies/one_way.yaml',
         'random_poses': 'auto'},
    ),
    (
        'Late neighbours',
        'Messages take tau = 2 s, own positions are exact: robots meet for any tau, but at '
        'sum_i (1 + K d_i tau) p_i(0) / sum_i (1 + K d_i tau), d_i = sum_j a_ij, instead of their '
        'mean, which is (0, 0) here.\n\nSource of the convergence: Moreau, Stability of '
        'continuous-time distributed consensus algorithms, IEEE Conference on Decision and '
        'Control, 2004.',
        {'nb_robots': 4, 'duration': 60.0, 'graph': 'star', 'delay': 2.0},
    ),
    (
        'All positions late',
        'If own positions are as late as those received, robots meet if and only if '
        '|lambda| tau < pi/2 - |arg lambda| for all eigenvalues of K L but 0; in an undirected '
        'graph tau < pi / (2 K lambda_N), which is 2.3 s here: tau = 2 s is just below. Only '
        'points without headings bear as much: see [Lab](lab.md).\n\n'
        'Source: Olfati-Saber and Murray, Consensus problems in networks of agents with switching '
        'topology and time-delays, IEEE Transactions on Automatic Control 49(9), 2004.',
        {'nb_robots': 4, 'duration': 90.0, 'graph': 'path', 'delay': 2.0, 'random_poses': 'auto',
         'set': {'DELAY': 2.0}},
    ),
    (
        'Events',
        'Robots send their position only when it is c away from the last position that they '
        'sent. Their laws use all positions as last sent, their own, too: in a balanced graph the '
        'mean is kept. They do not quite meet; in the long run their RMS distance from the centre '
        'is at most |L| c / lambda_2 in an undirected graph.\n\nSource: Seyboth, Dimarogonas '
        'and Johansson, Event-based broadcasting for multi-agent average consensus, Automatica '
        '49(1), 2013.',
        {'nb_robots': 6, 'duration': 60.0, 'graph': 'ring', 'event_triggered': True,
         'threshold': 0.2},
    ),
    (
        'Falling threshold',
        'The threshold c0 + c1 exp(-a t) falls from 1.02 to 0.02 m. No robot sends infinitely '
        'often in finite time, and the robots come as near to their centre as the bound above '
        'with c = c0: here with half as many messages as with 0.2 m, and nine times nearer.\n\n'
        'Source: Seyboth, Dimarogonas and Johansson, Event-based broadcasting for multi-agent '
        'average consensus, Automatica 49(1), 2013.',
        {'nb_robots': 6, 'duration': 60.0, 'graph': 'ring', 'event_triggered': True,
         'ctc': 'seyboth_2013'},
    ),
]  # fmt: skip
"""Conditions of Laplacian consensus: title, words and options."""

HEAD = """# Atlas of laws

The built-in control laws: formula, source, an example run, and what theory predicts for that run
(after a run with `--output out`, `setcmas metrics out --theory` prints it).
Copy one with `setcmas new my_law --from NAME`. The numbers were measured in the runs shown;
`docs/generators/atlas.py` makes this page.
"""


def main() -> None:
    """Write the page and a figure for each law."""
    page = [HEAD]
    for chapter, entries in CHAPTERS.items():
        page.append(f'## {chapter}\n')
        page += [entry(name, options) for name, options in entries]
        if chapter == 'Consensus':
            page.append('## Laplacian consensus over imperfect links\n')
            page += [scenario(*one) for one in SCENARIOS]
    (DOCS / 'atlas.md').write_text('\n'.join(page))


def entry(name: str, options: dict[str, Any]) -> str:
    """Return the section of a law; write its figure."""
    summary, _, rest = docstring(ALGORITHMS.file(name)).partition('\n\n')
    title, _, does = ' '.join(summary.split()).partition(': ')
    words = [f'### {title}\n', f'`{name}`: {does}\n', indented_as_code(rest)]
    return '\n'.join([*words, *example(name, options, name, 'trajectories')])


def scenario(title: str, words: str, options: dict[str, Any]) -> str:
    """Return the section of Laplacian consensus under other conditions; write its figure."""
    options = EXACT | options | {'set': EXACT['set'] | options.get('set', {})}
    name = title.lower().replace(' ', '_')
    head = [f'### {title}\n', words + '\n']
    plot = 'trajectories' if title in ('Late neighbours', 'Directed graph') else 'disagreement'
    return '\n'.join([*head, *example('laplacian_consensus', options, name, plot)])


def example(law: str, options: dict[str, Any], name: str, plot: str) -> list[str]:
    """Return the lines of an example run: figure, command, and prediction."""
    run = simulate(law, warn=print, **options)
    figure = run.plot(plot)
    figure.savefig(DOCS / 'pictures' / f'atlas_{name}.png', dpi=PLOT_DPI)
    shows = {'trajectories': 'Paths of the robots', 'disagreement': 'Disagreement over time'}[plot]
    given = {f'--{key.replace("_", "-")}': value for key, value in options.items()}
    words = [key if value is True else f'{key} {_typed(value)}' for key, value in given.items()]
    return [
        f'![{shows}](pictures/atlas_{name}.png){{ width="480" }}\n',
        f'```sh\nsetcmas offline --algo {law} {" ".join(words)}\n```\n',
        *theory(run),
    ]


def _typed(value: object) -> str:
    if isinstance(value, dict):
        return ' --set '.join(f'{name}={_typed(one)}' for name, one in value.items())
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
    """Return what `setcmas metrics --theory` prints of the prediction, or of the law's task."""
    metrics = run.metrics()
    found = metrics.get('prediction')
    predicts = isinstance(found, Comparison) and found.figures
    lines = found.lines if predicts else fleet_lines(metrics)
    return ['```text', *lines, '```', '']


if __name__ == '__main__':
    main()
