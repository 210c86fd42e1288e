"""Measure a run: path, speed and separation of the robots, and how well they did their task.

The table goes to the terminal and, without rounding to the table's digits, into metrics.yaml in
the folder of the run, or BAG_metrics.yaml beside a bag alone. The task is what the law says in a
line such as task = 'waypoints'; of a law that says none, it is told with --task, and its
references (WPL; PLACES; D; R and W) are read from the script.

Examples:
  setcmas metrics out                                a run's folder
  setcmas metrics out --task waypoints --algo my_law.py
  setcmas metrics somebody_elses.bag --vnom 0.2
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

from launch_scripts.terminal.terminal_output import teller
from setcmas_ctrl.control.references import TASKS
from setcmas_simu.options.group import Options, option
from setcmas_simu.options.kinds import Kind, Number

_tell = teller('metrics')


@dataclass(frozen=True, kw_only=True)
class MetricsOptions(Options):
    """What is measured against, where the run does not tell."""

    task: str | None = option(
        Kind(metavar='NAME'),
        'what the robots were to do',
        default=None,
        default_text='what the law says',
        complete=lambda **_: list(TASKS.offers()),
    )
    algo: str | None = option(
        Kind(metavar='NAME'),
        'control law that has the references of the task',
        default=None,
        default_text='that of the run',
    )
    vnom: float | None = option(
        Number(above=0, unit='m/s'),
        'largest speed of a robot in m/s',
        default=None,
        default_text='that of run.yaml, else 0.5',
    )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        'run',
        type=Path,
        metavar='DIR',
        help='folder of a run, of its CSV files, a fleet.csv, or a bag',
    )
    MetricsOptions.add_to(parser)


def main(args: argparse.Namespace) -> int:
    """Measure; returns the exit status."""
    from setcmas_tools.evaluation import evaluate
    from setcmas_tools.measures.metrics import FILE_NAME
    from setcmas_tools.measures.task import with_task, with_vnom
    from setcmas_tools.run.run import Run
    from setcmas_tools.run.run_folder import find_run

    source = find_run(args.run)
    run = Run.load(args.run, _tell)
    if args.task or args.algo:
        run = with_task(run, args.task, args.algo)
    if args.vnom:
        run = with_vnom(run, args.vnom)
    target = source.folder / f'{source.stem}{FILE_NAME}'
    evaluation = evaluate(run, metrics_file=target, warn=_tell)
    print(evaluation)
    if run.references is None:
        print(f'the task is not known: --task {{{",".join(TASKS.offers())}}} and --algo tell it')
    print(target)
    return 0
