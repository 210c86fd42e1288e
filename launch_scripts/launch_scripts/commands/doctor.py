"""Check this machine, and with --lab a lab: motion capture, robots, batteries, network.

No robot moves. Exit status: 0 if all is well, 1 if there are problems.

Examples:
  setcmas doctor
  setcmas doctor --lab lab.yaml
  setcmas doctor --emulate --nb-robots 3      check an emulated lab
"""

from __future__ import annotations

import argparse
import os
from dataclasses import replace

from tabulate import tabulate

from launch_scripts.environment import require_ros
from launch_scripts.experiment import experiment_environment, start_emulated_lab
from launch_scripts.processes import ChildDiedError
from launch_scripts.supervisor import StoppedError, Supervisor
from setcmas_expe.doctor.findings import (
    advice_lines,
    environment_findings,
    exit_status,
    missing_packages,
    table,
    verdict,
)
from setcmas_expe.emulation.emulation_options import check_emulated_mocap
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_file import LabOptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    LabOptions.add_to(parser)
    emulate = 'check an emulated lab on this machine'
    parser.add_argument('--emulate', action='store_true', help=emulate)


def main(args: argparse.Namespace) -> int:
    """Check; return the exit status."""
    options = LabOptions.of(args)
    lab = options.chosen()  # report mistakes before anything starts
    if args.emulate:
        check_emulated_mocap(lab.mocap)
        options = replace(options, nb_robots=lab.nb_robots)
    environment = experiment_environment(lab, args.emulate)
    os.environ.clear()
    os.environ.update(environment)  # before ROS starts
    name = str(options.lab or 'the default lab')
    if not args.emulate:
        return _examine(lab if options.changed() else None, name)
    require_ros()
    with Supervisor(environment, prefix=True) as supervisor:
        try:
            lab_process = start_emulated_lab(supervisor, options.arguments())
        except StoppedError:
            return 130
        except ChildDiedError as death:
            return supervisor.report_death(death, 'doctor')
        status = _examine(lab, name)
        if not lab_process.running():
            supervisor.warn(f'setcmas doctor: {lab_process.unexpected_end()}')
            return 1
        return status


def _examine(lab: Lab | None, name: str) -> int:
    """Print the findings about this machine, and about a lab of that name, if there is one."""
    if missing_packages():
        lab = None
    if lab:
        lab.mocap.source.message_class()
    findings = environment_findings()
    print(f'this machine\n{table(findings)}', flush=True)
    if lab:
        from setcmas_expe.doctor.lab_examination import COLUMNS, examine
        from setcmas_simu.ros.process import ros_process

        with ros_process() as process:
            rows, of_lab = examine(process, lab)
        if process.stopping:
            raise KeyboardInterrupt
        print(f'\nrobots of {name}\n{tabulate(rows, COLUMNS, disable_numparse=True)}')
        if of_lab:
            print(f'\n{table(of_lab)}')
        findings += of_lab
    if advice := advice_lines(findings):
        print('\nwhat to do\n' + '\n'.join(advice))
    print(f'\n{verdict(findings)}', flush=True)
    return exit_status(findings)
