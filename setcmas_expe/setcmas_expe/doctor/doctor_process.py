"""Doctor: checks of this machine, its network and a lab, with advice.

Run as `ros2 run setcmas_expe doctor`, or `... doctor --lab lab.yaml`.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import sys
from collections.abc import Mapping
from importlib import metadata

from tabulate import tabulate

from setcmas_expe.doctor.findings import (
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
from setcmas_simu.errors import SetcmasError, install_command
from setcmas_simu.option_groups import take_values

_PACKAGES = ('rclpy', 'nav_msgs', 'sensor_msgs', 'diagnostic_msgs', 'std_srvs')
_DEFAULT_RMW = 'rmw_fastrtps_cpp'
_DOMAINS = range(233)
_SHARED_DOMAINS = range(102, 215)  # whose ports Linux gives to other programs, too
_RANGES = ('SUBNET', 'LOCALHOST', 'SYSTEM_DEFAULT')  # with OFF, processes do not find each other
_PLATFORM = 'Linux x86_64, Python 3.10 to 3.13'
_WHEELS = f'{install_command("ros")} ({_PLATFORM}), or source an installed ROS 2 Jazzy'


def environment_findings() -> list[Finding]:
    """Return the findings about this machine."""
    variables = os.environ
    findings = [ros_finding(), rmw_finding(variables), domain_finding(variables)]
    return [*findings, discovery_finding(variables)]


def ros_finding() -> Finding:
    """Return whether the packages of ROS 2 are installed."""
    if missing := missing_packages():
        return Finding(PROBLEM, 'ROS 2', f'{", ".join(missing)} not found', _WHEELS)
    try:
        found = f'rclpy {metadata.version("ros-jazzy-rclpy")} from PyPI'
    except metadata.PackageNotFoundError:
        found = f'{os.environ.get("ROS_DISTRO", "rclpy")}, installed'
    distribution = os.environ.get('ROS_DISTRO', 'jazzy')
    if distribution != 'jazzy':
        return Finding(NOTE, 'ROS 2', found, 'setcmas is made for, and tested with, ROS 2 Jazzy')
    return Finding(OK, 'ROS 2', found)


def missing_packages() -> list[str]:
    """Return the packages of ROS 2 that are not there; without them no node can run."""
    return [name for name in _PACKAGES if importlib.util.find_spec(name) is None]


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


def _examine_lab(lab: Lab, name: str, ros_arguments: list[str]) -> list[Finding]:
    """Print the table of a lab's robots, and return the findings."""
    from setcmas_expe.doctor.lab_examination import COLUMNS, examine
    from setcmas_simu.ros.process import ros_process

    with ros_process(ros_arguments) as process:
        rows, findings = examine(process, lab)
        print(f'\nrobots of {name}')
        print(tabulate(rows, COLUMNS, disable_numparse=True), flush=True)
        if findings:
            print(f'\n{table(findings)}', flush=True)
    return findings


def main(argv: list[str] | None = None) -> int:
    """Check everything; return the exit status: 0 all well, 1 problems, 2 invalid input."""
    argv = sys.argv[1:] if argv is None else argv
    cut = argv.index('--ros-args') if '--ros-args' in argv else len(argv)
    parser = argparse.ArgumentParser(prog='doctor', description=__doc__)
    LabOptions.add_to(parser)
    take_values(parser)
    args = parser.parse_args(argv[:cut])
    try:
        return _examine(LabOptions.of(args), argv[cut:])
    except SetcmasError as error:
        print(f'setcmas doctor: {error}', file=sys.stderr)
        return 2


def _examine(options: LabOptions, ros_arguments: list[str]) -> int:
    lab = options.chosen() if options.changed() else None
    has_ros = not missing_packages()
    if lab and has_ros:
        lab.mocap.source.message_class()
    findings = environment_findings()
    print(f'this machine\n{table(findings)}', flush=True)
    if lab and has_ros:
        name = str(options.lab or 'the default lab')
        findings += _examine_lab(lab, name, ros_arguments)
    if advice := advice_lines(findings):
        print('\nwhat to do\n' + '\n'.join(advice))
    print(f'\n{verdict(findings)}')
    return exit_status(findings)


if __name__ == '__main__':
    sys.exit(main())
