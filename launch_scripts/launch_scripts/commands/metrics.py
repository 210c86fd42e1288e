"""Measure a run: path lengths, speeds and separation of the robots, and their task errors.

The table goes to the terminal, and the unrounded values to metrics.yaml in the run's folder, or
to BAG_metrics.yaml next to a single bag. The law declares its task in a line such as
task = 'waypoints', with references such as WPL.

Examples:
  setcmas metrics out                                a run's folder
  setcmas metrics out --theory                       also what theory predicts
"""

from __future__ import annotations

import argparse

from launch_scripts.commands.csv_to_plot import add_run_argument
from launch_scripts.terminal import warner

_warn = warner('metrics')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    add_run_argument(parser)
    theory = 'also show what theory predicts for a built-in law, and which effects it leaves out'
    parser.add_argument('--theory', action='store_true', help=theory)


def main(args: argparse.Namespace) -> int:
    """Measure; return the exit status."""
    from setcmas_tools.measures.metrics import FILE_NAME, measure, theory_lines, write_yaml
    from setcmas_tools.run.run import Run
    from setcmas_tools.run.run_folder import find_run

    source = find_run(args.run)
    run = Run.load(args.run, _warn)
    metrics = measure(run, _warn)
    target = source.folder / f'{source.stem}{FILE_NAME}'
    write_yaml(metrics, target)
    print(metrics)
    if args.theory:
        print(*theory_lines(metrics), sep='\n')
    print(target)
    return 0
