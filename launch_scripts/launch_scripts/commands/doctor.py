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
from collections.abc import Mapping
from dataclasses import replace
from importlib import metadata

from tabulate import tabulate

from launch_scripts.environment import check_ros, require_ros
from launch_scripts.experiment import experiment_environment, start_emulated_lab
from launch_scripts.processes import ChildDiedError
from launch_scripts.supervisor import StoppedError, Supervisor
from setcmas_expe.emulation.emulation_options import check_emulated_mocap
from setcmas_expe.lab.findings import (
    NOTE,
    OK,
    PROBLEM,
    Finding,
    advice_lines,
    exit_status,
    table,
    verdict,
)
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_file import LabOptions
from setcmas_simu.errors import SetcmasError

_DEFAULT_RMW = 'rmw_fastrtps_cpp'
_DOMAINS = range(233)
_SHARED_DOMAINS = range(102, 215)  # whose ports Linux gives to other programs, too
_RANGES = ('SUBNET', 'LOCALHOST', 'SYSTEM_DEFAULT')  # with OFF, processes do not find each other


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
    findings = [ros_finding(), rmw_finding(os.environ), domain_finding(os.environ)]
    findings.append(discovery_finding(os.environ))
    has_ros = findings[0].level != PROBLEM
    if lab and has_ros:
        lab.mocap.source.message_class()
    print(f'this machine\n{table(findings)}', flush=True)
    if lab and has_ros:
        from setcmas_expe.lab.lab_examination import COLUMNS, examine

        rows, of_lab = examine(lab)
        print(f'\nrobots of {name}\n{tabulate(rows, COLUMNS, disable_numparse=True)}')
        if of_lab:
            print(f'\n{table(of_lab)}')
        findings += of_lab
    if advice := advice_lines(findings):
        print('\nwhat to do\n' + '\n'.join(advice))
    print(f'\n{verdict(findings)}', flush=True)
    return exit_status(findings)


def ros_finding() -> Finding:
    """Return whether ROS 2 is installed, and works here."""
    try:
        check_ros()
    except SetcmasError as error:
        found, _, advice = str(error).partition(': ')
        return Finding(PROBLEM, 'ROS 2', found, advice)
    try:
        found = f'rclpy {metadata.version("ros-jazzy-rclpy")} from PyPI'
    except metadata.PackageNotFoundError:
        found = f'{os.environ.get("ROS_DISTRO", "rclpy")}, installed'
    distribution = os.environ.get('ROS_DISTRO', 'jazzy')
    if distribution != 'jazzy':
        return Finding(NOTE, 'ROS 2', found, 'setcmas is made for, and tested with, ROS 2 Jazzy')
    return Finding(OK, 'ROS 2', found)


def rmw_finding(variables: Mapping[str, str]) -> Finding:
    """Return the middleware in use."""
    name = variables.get('RMW_IMPLEMENTATION') or _DEFAULT_RMW
    if name == _DEFAULT_RMW:
        return Finding(OK, 'middleware', name)
    advice = f'use the same on all machines; setcmas is tested with {_DEFAULT_RMW}'
    return Finding(NOTE, 'middleware', f'RMW_IMPLEMENTATION={name}', advice)


def domain_finding(variables: Mapping[str, str]) -> Finding:
    """Return whether the ROS domain works on all systems."""
    text = variables.get('ROS_DOMAIN_ID') or '0'
    if not text.isdecimal() or int(text) not in _DOMAINS:
        return Finding(PROBLEM, 'ROS domain', f"'{text}'", 'set ROS_DOMAIN_ID to 0 to 101')
    if int(text) in _SHARED_DOMAINS:
        advice = 'other programs may hold its ports; set ROS_DOMAIN_ID to 0 to 101'
        return Finding(NOTE, 'ROS domain', text, advice)
    return Finding(OK, 'ROS domain', f'{text}; the robots must have the same one')


def discovery_finding(variables: Mapping[str, str]) -> Finding:
    """Return how processes and machines find each other."""
    if variables.get('ROS_LOCALHOST_ONLY') == '1':
        advice = 'unset ROS_LOCALHOST_ONLY: it hides the robots, and is deprecated in Jazzy'
        return Finding(PROBLEM, 'discovery', 'ROS_LOCALHOST_ONLY=1', advice)
    wanted = variables.get('ROS_AUTOMATIC_DISCOVERY_RANGE')
    if wanted is not None and wanted not in _RANGES:
        advice = f'set ROS_AUTOMATIC_DISCOVERY_RANGE to one of {", ".join(_RANGES)}'
        return Finding(PROBLEM, 'discovery', f'range {wanted}', advice)
    found = f'range {wanted}' if wanted else 'this machine in simulation, SUBNET in experiments'
    for name in ('ROS_STATIC_PEERS', 'ROS_DISCOVERY_SERVER'):
        if variables.get(name):
            found += f', {name}={variables[name]}'
    return Finding(OK, 'discovery', found)
