"""Run a control law many times offline, with some of its parameters varied.

Writes runs.csv, a row for each run, the plots, and study.yaml, which would repeat the study. The
same command in the same folder goes on where a study was stopped; a run whose law fails, hangs or
dies is a row that says so. A run of it is made again with --from FOLDER/NUMBER of setcmas offline
or run.

Examples:
  setcmas sweep --algo consensus --nb-robots 8 --vary K=0.2:2:10 --seeds 20 --random-poses -o study
  setcmas sweep --algo consensus --nb-robots 8 --vary graph=ring,path --vary loss=0,0.2,0.4
  setcmas sweep --algo consensus --nb-robots 8 --seeds 500 --random-poses --dry-run
  setcmas offline --from study/417 -o run            run 417 of that study again, with its plots
"""

from __future__ import annotations

import argparse
from dataclasses import fields
from pathlib import Path
from typing import Any

from launch_scripts.commands.plot_options import FormatOptions
from launch_scripts.commands.run_options import add_law_arguments, output_folder
from launch_scripts.terminal.terminal_output import warn
from setcmas_ctrl.communication.communication_options import CommunicationOptions
from setcmas_ctrl.control.control_options import SCRIPT_FAILED, GainOptions, LawOptions
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.run_folder import RunOptions
from setcmas_tools.study.study_options import SweepOptions

_AS_TYPED = (
    'algo', 'exercise', 'nb_robots', 'duration', 'model', 'limits', 'robot_rate', 'poses', 'pose',
    'random_poses', *(one.name for one in fields(GainOptions)),
    *(one.name for group in (CommunicationOptions, FilterOptions) for one in fields(group)),
)  # fmt: skip


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    RunOptions.add_to(parser)
    FormatOptions.add_to(parser)
    SweepOptions.add_to(parser)
    add_law_arguments(parser, without=('watch', 'cmd_timeout', 'lockstep', 'rtf'))


def main(args: argparse.Namespace) -> int:
    """Make a study, and write its table and plots; returns the exit status."""
    # Imported late: help texts and completion do not wait for numpy's and joblib's.
    from setcmas_tools.study.plan import check_names, make_plan
    from setcmas_tools.study.study import runs_in_words
    from setcmas_tools.study.success import check_columns
    from setcmas_tools.study.sweep import carry_out

    law, options = LawOptions.of(args), SweepOptions.of(args)
    CommunicationOptions.of(args)
    FilterOptions.of(args)
    parameters = {name: getattr(args, name) for name in _AS_TYPED} | {'set': dict(law.settings)}
    varied = list(map(_named, options.vary))
    check_names([name for name, _ in varied], seeds=1)
    plan = make_plan(parameters, dict(varied), options.cases, options.seeds, options.success)
    for metric in options.metric:
        check_columns(metric, [], '--metric')
    if options.dry_run:
        print(runs_in_words(len(plan.cases)))
        return 0
    folder = output_folder(args, law.scripts())
    try:
        study = carry_out(plan, folder, options, args.overwrite)
    except KeyboardInterrupt:
        warn(f"setcmas sweep: stopped; the same command with -o '{folder}' goes on from there")
        raise
    print(study.summary)
    drawn = _plots(study, folder, args) if args.plots else []
    told = f'   {len(drawn)} plots: {folder / "plots"}' if drawn else ''
    print(f'{runs_in_words(len(study))}: {folder / "runs.csv"}{told}')
    return SCRIPT_FAILED if _failures(study) else 0


def _named(text: str) -> tuple[str, str]:
    name, equals, values = text.partition('=')
    if not (name and equals and values):
        raise SetcmasError(f"--vary '{text}' must be NAME=VALUES, such as K=0.2:2:10")
    return name.strip(), values.strip()


def _plots(study: Any, folder: Path, args: argparse.Namespace) -> list[Path]:
    from setcmas_tools.plots.look import PlotLook
    from setcmas_tools.study.study_plots import plot

    look = PlotLook(tuple(args.format or ('png',)))
    return plot(study, folder / 'plots', args.metric, look)


def _failures(study: Any) -> int:
    """Tell how many runs did not go well, and why the first of each kind did not."""
    from setcmas_tools.study.study import runs_in_words

    first: dict[str, tuple[int, int]] = {}
    rows = zip(study['run'], study['state'], study['message'], strict=True)
    for run, state, message in rows:
        if state != 'complete':
            number, count = first.get(f'{state}: {message}', (int(run), 0))
            first[f'{state}: {message}'] = number, count + 1
    runs = runs_in_words(len(study))
    for text, (run, count) in sorted(first.items(), key=lambda one: -one[1][1])[:5]:
        warn(f'setcmas sweep: {count} of {runs}, the first is run {run}: {text}')
    return len(first)
