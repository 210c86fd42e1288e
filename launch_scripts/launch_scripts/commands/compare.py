"""Compare runs: paths, distances, metrics, parameters, scripts and versions.

The first run is the reference. If a run is an experiment, it is first shifted in time to fit best.
Two plots, of the paths and of the distances over time, are saved in a folder;
everything else is printed.

Examples:
  setcmas compare out_gain_1 out_gain_2
  setcmas compare simulation experiment -o sim_exp --format pdf
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.terminal import warner
from setcmas_simu.errors import SetcmasError
from setcmas_tools.plots.plot_options import PlotOptions

_warn = warner('compare')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    runs = 'two or more runs: folders of runs or of CSV files, fleet.csv files, or bags'
    parser.add_argument('runs', type=Path, nargs='+', metavar='DIR', help=runs)
    folder = 'folder of the plots (default: comparison)'
    parser.add_argument(
        '-o', '--output', type=Path, default='comparison', metavar='DIR', help=folder
    )
    PlotOptions.add_to(parser, without=('show',))


def main(args: argparse.Namespace) -> int:
    """Compare; return the exit status."""
    from setcmas_tools.measures.comparison import best_shift, differences, metrics_table
    from setcmas_tools.measures.metrics import measure
    from setcmas_tools.plots.plot import drawn_pictures
    from setcmas_tools.plots.style import write_figures
    from setcmas_tools.run.run import Run

    if len(args.runs) < 2:
        raise SetcmasError(f"'{args.runs[0]}' is only one run; name at least two to compare")
    names = list(map(str, args.runs))
    runs = [Run.load(path, _warn) for path in args.runs]
    metrics = [measure(run, _warn) for run in runs]
    shifted = [best_shift(runs[0], run) for run in runs[1:]]
    print(metrics_table(names, metrics))
    for name, run, shift in zip(names[1:], runs[1:], shifted, strict=True):
        found = [*differences(runs[0], run)] or ['parameters, files and versions are the same']
        print(f'\n{name} {shift}', *(f'  {line}' for line in found), sep='\n')
    drawn = drawn_pictures(names, runs, shifted)
    print(*write_figures(drawn, args.output, PlotOptions.of(args)), sep='\n')
    return 0
