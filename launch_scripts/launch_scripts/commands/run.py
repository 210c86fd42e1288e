"""Simulate robots under a control law, record the run, and write its CSV files and plots.

Examples:
  setcmas run square.yaml
  setcmas run --algo consensus --nb-robots 8 --duration 40 --output out
  setcmas run --algo nav_wp --pose 1:5,5,0 --duration 60
  setcmas run --algo my_law.py --nb-robots 4 --limits burger --set K=1.2
  setcmas run --algo consensus --nb-robots 8 --event-triggered --duration 45
  setcmas run --from out                                   repeat the run in out
"""

from __future__ import annotations

import argparse
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from launch_scripts.command_scenario import (
    add_from_argument,
    add_scenario_arguments,
    earlier_run,
    output_folder,
    scenario_to_simulate,
)
from launch_scripts.commands.csv_to_plot import print_evaluation
from launch_scripts.commands.view import ViewOptions, fleet_views
from launch_scripts.environment import local_environment, require_ros
from launch_scripts.recorded_run import STOPPED, ProgressSupervisor, SimulatedRun, run_robots
from launch_scripts.terminal import warn
from setcmas_simu.errors import SetcmasError
from setcmas_tools.plots.plot_options import PlotOptions
from setcmas_tools.run.run_folder import RunFolder, RunOptions, inputs_of, kept_record
from setcmas_tools.run.run_info import Outcome, RunInfo, RunState
from setcmas_tools.run.scenario import Scenario

_PARTS = ('law', 'robots', 'communication', 'safety', 'time')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    RunOptions.add_to(parser)
    PlotOptions.add_to(parser, without=('show',))
    add_scenario_arguments(parser, parts=_PARTS)
    add_from_argument(parser)
    ViewOptions.add_to(parser)


def main(args: argparse.Namespace) -> int:
    """Do the whole job; return the exit status."""
    scenario, earlier = scenario_to_simulate(args), earlier_run(args)
    folder, info = new_run(args, scenario)
    require_ros("'setcmas offline' takes the same options and needs no ROS; ")
    robots = list(range(1, scenario.nb_robots + 1))
    with (
        fleet_views(ViewOptions.of(args), robots) as views,
        ProgressSupervisor(local_environment(), prefix=True) as supervisor,
    ):
        status, ended = run_robots(
            'run',
            supervisor,
            lambda: SimulatedRun(supervisor, scenario, folder.bag),
            scenario.time.duration,
            folder,
            info,
            views,
        )
    return concluded(args, folder, ended, earlier, status)


def new_run(
    args: argparse.Namespace, scenario: Scenario, lab: dict[str, Any] | None = None
) -> tuple[RunFolder, RunInfo]:
    """Return the folder of a run, which can be written, and what its run.yaml begins with.

    Args:
        args: The options of the run.
        scenario: Its scenario.
        lab: Values of its lab that replace those of the scenario.

    Raises:
        SetcmasError: A script is missing, or the folder holds something else.
    """
    found = scenario.found()
    inputs = inputs_of(found)
    folder = RunFolder(output_folder(args, found), inputs)
    folder.check(args.overwrite)
    info = RunInfo(
        ['setcmas', *sys.argv[1:]],
        Outcome(RunState.NOT_FINISHED),
        kept_record(found, inputs),
        lab,
        started=time.strftime('%Y-%m-%dT%H:%M:%S%z'),
    )
    return folder, info


def concluded(
    args: argparse.Namespace,
    folder: RunFolder,
    info: RunInfo | None,
    earlier: Path | None,
    status: int,
) -> int:
    """Write the results of a run, and report them; return the exit status.

    Without `info` the run has not begun, and its folder goes.
    """
    if info is None:
        folder.discard()
        return status
    folder.write_info(info)
    if not folder.bag.exists():
        return status or 1
    try:
        status = _evaluate(args, folder, earlier) or status
        if info.outcome.state is RunState.FAILED:
            warn(f'setcmas {args.verb}: {info.outcome}; see the messages above the table')
        return status
    except KeyboardInterrupt:
        command = f'bag_to_csv {folder.bag}'
        warn(f'setcmas {args.verb}: the bag is complete; continue with {command}')
        return STOPPED
    except SetcmasError as error:
        if not status:
            raise
        warn(f'setcmas {args.verb}: {error}')  # the reason why the run ended matters more
        return status


def _evaluate(args: argparse.Namespace, folder: RunFolder, earlier: Path | None) -> int:
    """Write CSV files, plots and metrics, print these; return the exit status."""
    from setcmas_tools.run.bag_conversion import convert  # late, as in `print_evaluation`
    from setcmas_tools.run.run import Run

    report = convert(folder.bag, folder.csv)
    if not report.fleet:
        warn(f'setcmas {args.verb}: no odometry was recorded, so there are no plots')
        return 1
    run = Run.load(folder.path, warn)
    files = print_evaluation(args, folder, run, earlier)
    with suppress(OSError):  # the terminal may be closed; the work is done
        print(f'bag: {folder.bag}   {files}', flush=True)
    return 0
