"""Check this machine, and with --lab a lab: motion capture, robots, batteries, network.

No robot moves. Exit status: 0 if all is well, 1 if there are problems.

Examples:
  setcmas doctor
  setcmas doctor --lab lab.yaml
  setcmas doctor --emulate --nb-robots 3      check an emulated lab
"""

from __future__ import annotations

import argparse
import subprocess
from dataclasses import replace

from launch_scripts.environment import require_ros
from launch_scripts.experiment import experiment_environment, start_emulated_lab
from launch_scripts.processes import DOCTOR, ChildDiedError, node_command
from launch_scripts.supervisor import StoppedError, Supervisor
from setcmas_expe.emulation.emulation_options import check_emulated_mocap
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
    command = node_command(DOCTOR, options.arguments())
    environment = experiment_environment(lab, args.emulate)
    if not args.emulate:
        return subprocess.call(command, env=environment)
    require_ros()
    with Supervisor(environment, prefix=True) as supervisor:
        try:
            lab_process = start_emulated_lab(supervisor, options.arguments())
        except StoppedError:
            return 130
        except ChildDiedError as death:
            return supervisor.report_death(death, 'doctor')
        status = subprocess.call(command, env=environment)
        if not lab_process.running():
            supervisor.warn(f'setcmas doctor: {lab_process.unexpected_end()}')
            return 1
        return status
