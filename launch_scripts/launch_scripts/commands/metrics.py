"""Measure a run: path lengths, speeds and separation of the robots, and their task errors.

The table goes to the terminal, and the unrounded values to metrics.yaml in the run's folder, or
to BAG_metrics.yaml next to a single bag. The law declares its task in a line such as
task = 'waypoints'; otherwise give --task, and the references (WPL; PLACES; D; R and W) are read
from the script.

Examples:
  setcmas metrics out                                a run's folder
  setcmas metrics out --task waypoints --algo my_law.py
  setcmas metrics lab.bag --vnom 0.2
  setcmas metrics out --theory                       also what theory predicts
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

from launch_scripts.commands.plot_options import add_run_argument
from launch_scripts.terminal import warner
from setcmas_ctrl.laws.references import TASKS
from setcmas_simu.option_kinds import Kind, Number
from setcmas_simu.options import Options, option

_warn = warner('metrics')


@dataclass(frozen=True, kw_only=True)
class MetricsOptions(Options):
    """Task and speed limit to measure against, if the run does not have them."""

    task: str | None = option(
        Kind(metavar='NAME'),
        'task of the robots',
        default=None,
        default_text='as declared by the law',
        complete=lambda **_: list(TASKS.plugins()),
    )
    algo: str | None = option(
        Kind(metavar='NAME'),
        'control law with the references of the task',
        default=None,
        default_text="the run's",
    )
    vnom: float | None = option(
        Number(above=0, unit='m/s'),
        'speed limit of the robots in m/s',
        default=None,
        default_text='as in run.yaml, else 0.5',
    )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    add_run_argument(parser)
    MetricsOptions.add_to(parser)
    theory = 'also show what theory predicts for a built-in law, and which effects it leaves out'
    parser.add_argument('--theory', action='store_true', help=theory)


def main(args: argparse.Namespace) -> int:
    """Measure; return the exit status."""
    from setcmas_tools.measures.metrics import FILE_NAME, theory_lines
    from setcmas_tools.measures.task import with_task, with_vnom
    from setcmas_tools.plots.evaluation import evaluate
    from setcmas_tools.run.run import Run
    from setcmas_tools.run.run_folder import find_run

    source = find_run(args.run)
    run = Run.load(args.run, _warn)
    if args.task or args.algo:
        run = with_task(run, args.task, args.algo)
    if args.vnom:
        run = with_vnom(run, args.vnom)
    target = source.folder / f'{source.stem}{FILE_NAME}'
    evaluation = evaluate(run, metrics_file=target, warn=_warn)
    print(evaluation)
    if args.theory and evaluation.metrics:
        print(*theory_lines(evaluation.metrics.parts), sep='\n')
    if run.references is None and not any(one.option == 'algo' for one in run.inputs):
        tasks = ','.join(TASKS.plugins())
        print(
            f'the task is unknown, so task errors are missing; add --task {{{tasks}}} and --algo '
            'SCRIPT'
        )
    print(target)
    return 0
