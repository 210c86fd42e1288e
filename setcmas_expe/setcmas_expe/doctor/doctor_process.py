"""Doctor: checks of this machine, its network and a lab, with advice.

Run as `ros2 run setcmas_expe doctor`, or `... doctor --lab lab.yaml`.
"""

from __future__ import annotations

import argparse
import sys

from tabulate import tabulate

from setcmas_expe.doctor.findings import Finding, advice_lines, exit_status, table, verdict
from setcmas_expe.doctor.machine_checks import environment_findings, missing_packages
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_options import LabOptions
from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.group import take_values


def _other_fleets(ros_arguments: list[str]) -> Finding:
    # Imported late: the checks of this machine need no ROS.
    from setcmas_expe.doctor.lab_examination import other_fleets
    from setcmas_simu.ros.process import ros_process

    with ros_process(ros_arguments) as process:
        return other_fleets(process)


def _examine_lab(lab: Lab, name: str, ros_arguments: list[str]) -> list[Finding]:
    """Print the table of a lab's robots, and return the findings."""
    from setcmas_expe.doctor.lab_checks import COLUMNS
    from setcmas_expe.doctor.lab_examination import examine
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
    if has_ros and not lab:
        findings.append(_other_fleets(ros_arguments))
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
