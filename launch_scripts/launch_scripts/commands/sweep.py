"""Run a control law many times offline with varied parameters.

Writes runs.csv with a row per run, plots, and run.yaml with the scenario of the first run. To
repeat another, use setcmas offline (or run) --from FOLDER with the values in its row. A run whose
law fails, hangs or dies still gets a row. Ctrl-C ends a study early and writes the rows so far.

Examples:
  setcmas sweep square.yaml --vary K=0.5,1,2
  setcmas sweep --algo consensus --nb-robots 8 --vary K=0.2:2:10 --seeds 20 --random-poses -o study
  setcmas sweep --algo consensus --nb-robots 8 --vary graph=ring,path --vary loss=0,0.2,0.4
  setcmas offline --from study --seed 7 --set K=1.2 -o run        repeat a run, with plots
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from typing import Any, ClassVar

from launch_scripts.command_scenario import (
    add_scenario_arguments,
    output_folder,
    scenario_of,
)
from launch_scripts.terminal import warn
from setcmas_ctrl.laws.control_options import SCRIPT_FAILED
from setcmas_simu.errors import SetcmasError
from setcmas_simu.option_groups import Form, Options, option
from setcmas_simu.option_kinds import DURATION, Kind, Whole
from setcmas_tools.plots.plot_options import PlotOptions
from setcmas_tools.run.run_folder import STUDY_TABLE, RunOptions


@dataclass(frozen=True, kw_only=True)
class SweepOptions(Options):
    """Varied values of a study, its metrics and its workers."""

    TITLE: ClassVar[str] = 'study'

    vary: tuple[str, ...] = option(
        Kind(metavar='NAME=VALUES'),
        'vary an option or a variable of the script: a list (loss=0,0.2,0.4), a range '
        'FIRST:LAST:COUNT (K=0.2:2:10) or log:FIRST:LAST:COUNT; repeat it to run all '
        'combinations',
        form=Form.REPEATED,
        default=(),
    )
    seeds: int = option(Whole(1), 'seeds per case, starting at --seed', default=1)
    metric: tuple[str, ...] = option(
        Kind(metavar='COLUMN'),
        'metric to plot, such as disagreement (see setcmas list); may be repeated',
        form=Form.REPEATED,
        default=(),
    )
    jobs: int | None = option(
        Whole(1), 'simultaneous runs', default=None, default_text='the number of cores'
    )
    timeout: float = option(DURATION, 'time limit of a run', default=60.0)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    RunOptions.add_to(parser)
    PlotOptions.add_to(parser, without=('show',))
    SweepOptions.add_to(parser)
    add_scenario_arguments(parser, without=('cmd_timeout', 'rtf'))


def main(args: argparse.Namespace) -> int:
    """Make a study, and write its table and plots; return the exit status."""
    # Imported late: help texts and completion need not wait for numpy and joblib.
    from setcmas_tools.study.study import carry_out, runs_in_words
    from setcmas_tools.study.study_columns import check_known
    from setcmas_tools.study.study_plan import make_plan

    scenario, options = scenario_of(args), SweepOptions.of(args)
    check_known(options.metric)
    plan = make_plan(scenario, map(_named, options.vary), options.seeds)
    folder = output_folder(args, scenario.found())
    try:
        study = carry_out(plan, folder, options.jobs, options.timeout, args.overwrite)
    except KeyboardInterrupt:
        has_runs = (folder / STUDY_TABLE).is_file()
        done = f"'{folder}' has the runs" if has_runs else 'there are no runs'
        warn(f'setcmas sweep: stopped; {done} that had finished')
        raise
    print(study.summary)
    drawn = []
    if args.plots:
        from setcmas_tools.study.study_plots import plot

        drawn = plot(study, folder / 'plots', options.metric, PlotOptions.of(args))
    plots = f'   {len(drawn)} plots: {folder / "plots"}' if drawn else ''
    print(f'{runs_in_words(len(study))}: {folder / STUDY_TABLE}{plots}')
    return SCRIPT_FAILED if _failures(study) else 0


def _named(text: str) -> tuple[str, str]:
    name, equals, values = text.partition('=')
    if not (name and equals and values):
        raise SetcmasError(f"invalid --vary '{text}'; must be NAME=VALUES, such as K=0.2:2:10")
    return name.strip(), values.strip()


def _failures(study: Any) -> int:
    """Report runs that failed, with the first reason of each kind; return their number."""
    from setcmas_tools.study.study import runs_in_words

    broken = study.table[study.is_broken]
    kinds = broken.groupby(['state', 'message'], sort=False)['run'].agg(['count', 'first'])
    for (state, message), found in kinds.nlargest(5, 'count').iterrows():
        runs = f'{found["count"]} of {runs_in_words(len(study))}, first run {found["first"]}'
        warn(f'setcmas sweep: {runs}: {state}: {message}')
    return len(broken)
