"""Explain a run step by step, from the single integrators of theory to what was recorded.

Simulates the law from the start poses of the run: first as in theory, with single integrators and
a continuous law, then with one more property of the run at each step, as far as the run has it:
sampling, speed limit, dead band of the law, its robots, its imperfect messages, safety filter,
identified robots. The last row is the recorded run. How far the robots of each step are from
those of the step before shows what the added property changes, given the earlier ones.

Examples:
  setcmas explain out
  setcmas explain lab --model model.yaml       an experiment, with the model of setcmas identify
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.commands.csv_to_plot import add_run_argument
from launch_scripts.terminal import warner
from setcmas_simu.errors import SetcmasError

_warn = warner('explain')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    add_run_argument(parser)
    model = 'model file of setcmas identify, for the last simulation'
    parser.add_argument('--model', type=Path, metavar='FILE', help=model)


def main(args: argparse.Namespace) -> int:
    """Explain; return the exit status."""
    from setcmas_tools.measures.explanation import explanation, explanation_table
    from setcmas_tools.run.run import Run
    from setcmas_tools.run.run_folder import find_run
    from setcmas_tools.run.run_info import INFO_FILE
    from setcmas_tools.run.scenario import Scenario

    source = find_run(args.run)
    info = source.folder / INFO_FILE
    if not info.is_file():
        raise SetcmasError(
            f"'{args.run}' has no {INFO_FILE}, so its law is unknown; name a run of setcmas"
        )
    scenario = Scenario.load(info)
    if args.model:
        scenario = scenario.replace(model=str(args.model))
    run = Run.load(args.run, _warn)
    print(explanation_table(explanation(run, scenario, _warn)))
    return 0
