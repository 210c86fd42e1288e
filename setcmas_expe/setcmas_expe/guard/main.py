"""Process of a guard, on a robot's own computer: decides what reaches the wheels.

Run as `ros2 run setcmas_expe cmd_vel_guard --ros-args -r __ns:=/tb3_1`.
"""

from __future__ import annotations

import argparse
import sys
import time

from setcmas_expe.guard import watchdog
from setcmas_expe.guard.node import CmdVelGuard
from setcmas_expe.guard.options import GuardOptions
from setcmas_simu.ros.process import RosProcess, node_main
from setcmas_simu.ros.step_loop import StepLoop


def main(argv: list[str] | None = None) -> int:
    """Guard until a signal arrives; returns the exit status."""
    parser = argparse.ArgumentParser(prog='cmd_vel_guard', description=__doc__)
    GuardOptions.add_to(parser)
    return node_main(parser, _guard, argv)


def _guard(process: RosProcess, args: argparse.Namespace) -> None:
    guard = CmdVelGuard(GuardOptions.of(args), now=time.monotonic())

    def step(now: float) -> None:
        guard.step(now)
        watchdog.live()
        loop.period = guard.period

    loop = StepLoop(process, guard.period, step)
    try:
        loop.run()
    finally:
        guard.stop()


if __name__ == '__main__':
    sys.exit(main())
