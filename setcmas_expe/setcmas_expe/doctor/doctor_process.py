"""Doctor: checks of this machine, its network and a lab, with advice.

Run as `ros2 run setcmas_expe doctor`, or `... doctor --lab lab.yaml`.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from setcmas_expe.doctor.findings import Finding, advice_lines, exit_status, table, verdict
from setcmas_expe.doctor.machine_checks import environment_findings, ros_is_there
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_options import LabOptions
from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.group import Options, flag, option, take_values
from setcmas_simu.options.kinds import PathTo
from setcmas_simu.table import Table

if TYPE_CHECKING:
    from setcmas_simu.ros.process import RosProcess

_QUESTION = 'Nudge each robot 5 cm forward and back? People and obstacles clear? [y/N] '


@dataclass(frozen=True, kw_only=True)
class DoctorOptions(Options):
    """Active checks of the doctor."""

    nudge: bool = flag(
        'nudge each robot without asking: 5 cm forward and back, and a small turn; clear the way '
        'first'
    )
    camera: Path | None = option(
        PathTo(metavar='FILE'), 'camera file: check its cameras', default=None
    )


def _other_fleets(ros_arguments: list[str]) -> Finding:
    # Imported late: the checks of this machine need no ROS.
    from setcmas_expe.doctor.lab_examination import other_fleets
    from setcmas_simu.ros.process import ros_process

    with ros_process(ros_arguments) as process:
        return other_fleets(process)


def _examine_lab(lab: Lab, name: str, nudge: bool, ros_arguments: list[str]) -> list[Finding]:
    """Print the table of a lab's robots, nudge them if wanted, and return the findings."""
    from setcmas_expe.doctor.lab_checks import COLUMNS
    from setcmas_expe.doctor.lab_examination import examine, watched_lab
    from setcmas_expe.doctor.nudge import Nudger
    from setcmas_simu.ros.process import ros_process

    with ros_process(ros_arguments) as process:
        watch = watched_lab(process, lab)
        rows, findings = examine(watch)
        print(f'\nrobots of {name}')
        print(Table(rows, COLUMNS), flush=True)
        if findings:
            print(f'\n{table(findings)}', flush=True)
        if not process.stopping and (nudge or _confirmed(process)):
            process.spin_until(lambda: False, 0.2)  # messages that came during the question
            nudges = list(Nudger(process, watch).findings())
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
    parser = argparse.ArgumentParser(prog='doctor', description=__doc__)
    LabOptions.add_to(parser)
    DoctorOptions.add_to(parser)
    take_values(parser)
    args = parser.parse_args(argv[:cut])
    try:
        return _examine(LabOptions.of(args), DoctorOptions.of(args), argv[cut:])
    except SetcmasError as error:
        print(f'setcmas doctor: {error}', file=sys.stderr)
        return 2


def _examine(options: LabOptions, doctor: DoctorOptions, ros_arguments: list[str]) -> int:
    if doctor.camera:
        return _examine_cameras(doctor.camera, options.chosen())
    lab = options.chosen() if doctor.nudge or options.changed() else None
    has_ros = ros_is_there()
    if lab and has_ros:
        lab.mocap.source.message_class()
    findings = environment_findings()
    if has_ros and not lab:
        findings.append(_other_fleets(ros_arguments))
    print(f'this machine\n{table(findings)}', flush=True)
    if lab and has_ros:
        name = str(options.lab or 'the default lab')
        findings += _examine_lab(lab, name, doctor.nudge, ros_arguments)
    return _conclude(findings)


def _examine_cameras(file: Path, lab: Lab) -> int:
    from setcmas_expe.doctor.camera_checks import camera_findings  # it needs OpenCV

    findings = camera_findings(file, lab)
    print(f'cameras of {file}\n{table(findings)}', flush=True)
    return _conclude(findings)


def _conclude(findings: list[Finding]) -> int:
    if advice := advice_lines(findings):
        print('\nwhat to do\n' + '\n'.join(advice))
    print(f'\n{verdict(findings)}')
    return exit_status(findings)


if __name__ == '__main__':
    sys.exit(main())
