"""Findings of checks: those of this machine; the table, advice and verdict of all."""

from __future__ import annotations

import importlib.util
import os
import textwrap
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import metadata

from tabulate import tabulate

from setcmas_simu.errors import install_command

OK = 'ok'
NOTE = 'note'
PROBLEM = 'PROBLEM'

_WIDTH = 99


@dataclass(frozen=True)
class Finding:
    """The outcome of one check.

    Attributes:
        level: OK, NOTE (works, with a remark) or PROBLEM (does not work).
        what: Subject of the check.
        advice: What to do; empty if nothing.
    """

    level: str
    what: str
    found: str
    advice: str = ''


def table(findings: Iterable[Finding]) -> str:
    """Return a table with a line for each finding."""
    rows = [(finding.level, finding.what, finding.found) for finding in findings]
    table: str = tabulate(rows, tablefmt='plain', disable_numparse=True)
    return table


def advice_lines(findings: Iterable[Finding]) -> list[str]:
    """Return the advice, problems first, each once, wrapped to the width of a terminal."""
    subjects: dict[str, list[str]] = {}
    for finding in sorted(findings, key=lambda finding: finding.level != PROBLEM):
        if finding.advice:
            subjects.setdefault(finding.advice, []).append(finding.what)
    wrapper = textwrap.TextWrapper(
        _WIDTH,
        initial_indent='- ',
        subsequent_indent='  ',
        break_long_words=False,
        break_on_hyphens=False,
    )
    lines = []
    for advice, whats in subjects.items():
        lines += wrapper.wrap(f'{", ".join(dict.fromkeys(whats))}: {advice}')
    return lines


def verdict(findings: Iterable[Finding]) -> str:
    """Return the verdict over all findings in one line."""
    levels = [finding.level for finding in findings]
    problems, notes = levels.count(PROBLEM), levels.count(NOTE)
    if problems:
        return f'{problems} problem{"s" * (problems > 1)}: see what to do above'
    return 'all well' + (f', with {notes} note{"s" * (notes > 1)}' if notes else '')


def exit_status(findings: Iterable[Finding]) -> int:
    """Return 0 if there is no problem, else 1."""
    return int(any(finding.level == PROBLEM for finding in findings))


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
