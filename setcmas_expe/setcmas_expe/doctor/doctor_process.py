"""Doctor: checks of this machine, its network and a lab, with advice.

Run as `ros2 run setcmas_expe doctor`, or `... doctor --lab lab.yaml`.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING

from setcmas_expe.doctor.findings import Finding, advice_lines, exit_status, table, verdict
from setcmas_expe.doctor.machine_checks import environment_findings, ros_is_there
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_options import LabOptions
from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.group import Options, flag, take_values
from setcmas_simu.table import Table


@dataclass(frozen=True, kw_only=True)
class DoctorOptions(Options):
    """Active checks of the doctor."""

    nudge: bool = flag(
        'nudge each robot without asking: 5 cm forward and back, and a small turn; clear the way '
        'first'
    )


if TYPE_CHECKING:
    from setcmas_simu.ros.process import RosProcess

_WATCH_S = 3.0
_SIGHT_S = 2.0
_QUESTION = 'Nudge each robot 5 cm forward and back? People and obstacles clear? [y/N] '


def look_around(ros_arguments: list[str]) -> list[Finding]:
    """Return the other fleets in sight."""
    from setcmas_expe.doctor.lab_examination import fleets_finding
    from setcmas_simu.ros.fleet_topic import FleetListener
    from setcmas_simu.ros.process import FleetNode, ros_process

    with ros_process(ros_arguments) as process:
        node = FleetNode('doctor')
        announced = FleetListener(node)
        process.add(node)
        process.spin_until(lambda: False, _SIGHT_S)
        return [fleets_finding(node, announced)]


def examine_lab(lab: Lab, name: str, nudge: bool, ros_arguments: list[str]) -> list[Finding]:
    """Print the table of a lab's robots, nudge them if wanted, and return the findings."""
    # Imported late: the checks of this machine need no ROS.
    from setcmas_expe.doctor.lab_examination import LabExamination
    from setcmas_simu.ros.process import ros_process

    with ros_process(ros_arguments) as process:
        examination = LabExamination(process, lab)
        examination.watch(_WATCH_S)
        columns, rows, findings = examination.result()
        print(f'\nrobots of {name}')
        print(Table(rows, columns), flush=True)
        if findings:
            print(f'\n{table(findings)}', flush=True)
        if not process.stopping and (nudge or _confirmed(process)):
            nudges = examination.nudge()
            print(f'\nnudges\n{table(nudges)}', flush=True)
            findings += nudges
    return findings


def _confirmed(process: RosProcess) -> bool:
    """Ask the user at the terminal; return False without one."""
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        return False

    def give_up() -> None:
        raise KeyboardInterrupt

    process.on_stop_signal = give_up
    try:
        return input(f'\n{_QUESTION}').strip().lower() in ('y', 'yes')
    except (EOFError, KeyboardInterrupt):
        print()
        return False
    finally:
        process.on_stop_signal = None


def main(argv: list[str] | None = None) -> int:
    """Check everything; return the exit status: 0 all well, 1 problems, 2 invalid input."""
    argv = sys.argv[1:] if argv is None else argv
    cut = argv.index('--ros-args') if '--ros-args' in argv else len(argv)
    argv, ros_arguments = argv[:cut], argv[cut:]
    parser = argparse.ArgumentParser(prog='doctor', description=__doc__)
    LabOptions.add_to(parser)
    DoctorOptions.add_to(parser)
    take_values(parser)
    args = parser.parse_args(argv)
    try:
        return _examine(args, ros_arguments)
    except SetcmasError as error:
        print(f'setcmas doctor: {error}', file=sys.stderr)
        return 2


def _examine(args: argparse.Namespace, ros_arguments: list[str]) -> int:
    options, nudge = LabOptions.of(args), DoctorOptions.of(args).nudge
    lab = options.chosen() if nudge or options.changed() else None
    if lab and ros_is_there():
        lab.mocap.source.message_class()
    findings = environment_findings()
    if ros_is_there() and lab is None:
        findings += look_around(ros_arguments)
    print(f'this machine\n{table(findings)}', flush=True)
    if lab and ros_is_there():
        name = str(options.lab or 'the default lab')
        findings += examine_lab(lab, name, nudge, ros_arguments)
    advice = advice_lines(findings)
    if advice:
        print('\nwhat to do\n' + '\n'.join(advice))
    print(f'\n{verdict(findings)}')
    return exit_status(findings)


if __name__ == '__main__':
    sys.exit(main())
