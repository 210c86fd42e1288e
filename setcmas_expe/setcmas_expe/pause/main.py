"""Process of the pause node of an experiment.

Run as `ros2 run setcmas_expe pause`; `setcmas expe` does it for you.
"""

from __future__ import annotations

import argparse
import sys

from setcmas_expe.lab.lab_options import LabOptions
from setcmas_expe.pause.console_reader import ConsoleReader
from setcmas_expe.pause.node import Pause
from setcmas_simu.ros.process import RosProcess, node_main


def main(argv: list[str] | None = None) -> int:
    """Serve until a signal arrives; returns the exit status."""
    parser = argparse.ArgumentParser(prog='pause', description=__doc__)
    LabOptions.add_to(parser)
    parser.add_argument(
        '--console', action='store_true', help='keys come on standard input from setcmas expe'
    )
    parser.add_argument(
        '--hold', action='store_true', help='robots move only while a key or button is held'
    )
    parser.add_argument(
        '--joystick', action='store_true', help='there is a joystick, which may start robots'
    )
    return node_main(parser, _serve, argv)


def _serve(process: RosProcess, args: argparse.Namespace) -> None:
    lab = LabOptions.of(args).chosen()
    keys = ConsoleReader(process.stop) if args.console else None
    node = Pause(lab, keys, process.launcher, args.hold, args.joystick)
    process.add(node)
    try:
        process.spin()
    finally:  # whatever happens in a callback
        node.set(True, 'the pause node ends')


if __name__ == '__main__':
    sys.exit(main())
