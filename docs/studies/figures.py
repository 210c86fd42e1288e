"""The figures of theory and measurement on the page on studies.

python docs/studies/figures.py FOLDER

A few minutes on two cores; the studies are kept in the folder, and only drawn if they are there.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from setcmas_ctrl.communication.graph import PRESETS, laplacian
from setcmas_tools import Study, sweep
from setcmas_tools.plots.style import plot_style, save
from setcmas_tools.study.study_plots import spread

HERE = Path(__file__).parent
NB_ROBOTS = 8
GRAPHS = ('path', 'ring', 'star', 'complete')
SEEDS = 25
LINEAR = {'model': 'omnidirectional', 'vnom': 50.0, 'rate': 25.0, 'robot_rate': 25.0}
"""Robots that do what the law says, as the theory has them."""


def rates(output: Path) -> Study:
    """Return the study of the rate of consensus against gain and graph."""
    return sweep(
        str(HERE / 'average.py'), NB_ROBOTS, 250.0,
        vary={'graph': list(GRAPHS), 'K': '0.05,0.1,0.2,0.3,0.5'},
        seeds=5, random_poses='auto', output=output, **LINEAR,
    )  # fmt: skip


def thresholds(output: Path) -> Study:
    """Return the study of messages and settling time against the threshold of triggering."""
    return sweep(
        str(HERE / 'average.py'), NB_ROBOTS, 250.0,
        vary={'threshold': 'log:0.04:1:9'}, set={'K': 0.05}, seeds=SEEDS, graph='ring',
        random_poses='auto', event_triggered=True, output=output, **LINEAR,
    )  # fmt: skip


def draw_rates(study: Study) -> Figure:
    """Draw measured rates against K lambda_2, and the line on which they should be."""
    figure = Figure(figsize=(7.0, 5.0))
    axes = figure.add_subplot(
        title=f'Rate of consensus, {NB_ROBOTS} robots',
        xlabel=r'$K \lambda_2$ (1/s)', ylabel='measured rate of convergence (1/s)',
    )  # fmt: skip
    for graph, marker in zip(GRAPHS, 'osD^', strict=True):
        algebraic = algebraic_connectivity(graph)
        rows = study.table['graph'] == graph
        x, y = study.table['K'][rows] * algebraic, study.numbers('convergence_rate')[rows]
        label = rf'{graph}, $\lambda_2$ = {algebraic:.3g}'
        axes.loglog(x, y, marker, alpha=0.7, label=label)
    line = np.array(axes.get_xlim())
    axes.loglog(line, line, color='0.3', linewidth=1, zorder=1, label=r'theory: $K \lambda_2$')
    axes.legend()
    return figure


def draw_thresholds(study: Study) -> Figure:
    """Draw messages, settling time and what is left of the disagreement, with the theory's."""
    figure = Figure(figsize=(12.0, 4.8))
    panels = figure.subplots(1, 3)
    d = np.sort(study.table['threshold'].unique())
    names = {
        'communications': 'states sent', 'settling_time': 'settling time, 5 % (s)',
        'disagreement': 'disagreement at the end (m)',
    }  # fmt: skip
    for axes, (name, label) in zip(panels, names.items(), strict=True):
        low, middle, high = (
            spread(study.numbers(name), study.table['threshold']).loc[d].to_numpy().T
        )
        top = 1.1 * max(middle[np.isfinite(middle)].max(), high[np.isfinite(high)].max())
        axes.fill_between(d, low, np.minimum(high, top), alpha=0.2, linewidth=0)
        (line,) = axes.plot(d, middle, 'o-', label=f'median and 90 % of {SEEDS} seeds')
        if (never := np.isinf(middle)).any():
            look = {'marker': '^', 'linestyle': '', 'color': line.get_color(), 'mfc': 'white'}
            axes.plot(d[never], 0 * d[never] + top, label='never in most runs', **look)
        axes.set(xscale='log', xlabel='threshold d (m)', ylabel=label)
    way = np.median([total_way(study, run) for run in range(1, SEEDS + 1)])
    panels[0].set_yscale('log')
    panels[0].plot(d, NB_ROBOTS + way / d, 'k--', label=r'$N + \Sigma_i |p_i(0) - \bar{p}| / d$')
    slowest = algebraic_connectivity('ring')
    settling = np.log(20) / (slowest * study.base.law.set['K'])
    panels[1].axhline(
        settling,
        color='k',
        linestyle='--',
        label=r'without triggering at most $\ln 20 / (K \lambda_2)$',
    )
    panels[2].set_yscale('log')
    panels[2].plot(d, 4 / slowest * d, 'k--', label=r'bound: $\|L\| d / \lambda_2$')
    for axes in panels:
        axes.legend(loc='lower center', bbox_to_anchor=(0.5, 1.0))
    return figure


def algebraic_connectivity(graph: str) -> float:
    """Return lambda_2, the second smallest eigenvalue of a graph's Laplacian."""
    return float(np.sort(np.linalg.eigvalsh(laplacian(PRESETS[graph](NB_ROBOTS))))[1])


def total_way(study: Study, run: int) -> float:
    """Return how far robots are from their centre at the start of a run, in all, in m."""
    start = study.run(run).poses[0, :2]
    return float(np.hypot(*(start - start.mean(axis=1, keepdims=True))).sum())


def main() -> None:
    """Make the studies and write the figures."""
    for name, study, draw in (
        ('consensus_rate', rates, draw_rates),
        ('event_threshold', thresholds, draw_thresholds),
    ):
        folder = Path(sys.argv[1]) / name
        made = Study.load(folder) if folder.exists() else study(folder)
        with plot_style():
            save(draw(made), HERE.parent / 'pictures' / f'{name}.png')


if __name__ == '__main__':
    main()
