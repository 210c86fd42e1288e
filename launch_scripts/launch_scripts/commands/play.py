"""Play a recording: publish its messages again, in time, for the view, RViz and recorders.

Commands are left out (cmd_vel, pause, reset, joysticks), whoever listens: no robot moves because
of a recording. It refuses to start where one of its robots is there, and ends when one comes.
Space pauses, the right and left arrows step by 0.1 s, q stops.

Examples:
  setcmas play out
  setcmas play out --rate 5 --loop
  setcmas play out/bag --start 20 --topics /tb3_1/odom /fleet
"""

from __future__ import annotations

import argparse
import re
from functools import partial
from pathlib import Path
from typing import NoReturn

from tqdm import tqdm

from launch_scripts.processes.environment import local_environment, require_ros
from launch_scripts.processes.node_commands import PLAYER, node_command
from launch_scripts.processes.supervision.child_process import Child, ChildDiedError, ChildReport
from launch_scripts.processes.supervision.supervisor import StoppedError, Supervisor
from launch_scripts.terminal.keyboard import Keyboard
from launch_scripts.terminal.output_lines import Stream, write_line
from setcmas_tools.player.options import PlayerOptions
from setcmas_tools.player.protocol import Key, Playing, Pressed

_KEYS = {' ': Key.TOGGLE, '\x1b[C': Key.FORTH, '\x1b[D': Key.BACK}
_FORM = '{desc}: {percentage:3.0f}%|{bar}| {n:.1f}/{total:.1f} s'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument('bag', type=Path, metavar='BAG', help='folder of a run, or a rosbag2 bag')
    PlayerOptions.add_to(parser)


def main(args: argparse.Namespace) -> int:
    """Play until the end or Ctrl-C; returns the exit status."""
    options = PlayerOptions.of(args)
    require_ros()
    command = node_command(PLAYER, [str(args.bag), *options.arguments()])
    with Keyboard() as keyboard, Supervisor(local_environment()) as supervisor:
        bar: tqdm[NoReturn] = tqdm(
            desc='playing',
            total=1.0,
            bar_format=_FORM,
            disable=None,
            leave=False,
            file=supervisor.stderr,
        )
        supervisor.write = partial(_write, supervisor)
        with bar:
            return _play(supervisor, keyboard, bar, command)


def _play(
    supervisor: Supervisor, keyboard: Keyboard, bar: tqdm[NoReturn], command: list[str]
) -> int:
    child = supervisor.start('play', command, listens=True)
    child.on_report = partial(_show, bar)
    try:
        supervisor.run(on_tick=lambda: _pass_on(keyboard.pressed(), child))
    except StoppedError:
        supervisor.stop(child)
        return child.exit_status
    except ChildDiedError as death:  # at the end of the bag, too
        status = child.process.returncode
        if status < 0:
            supervisor.warn(f'setcmas play: {death}')
        return death.exit_status if status else 0
    return 0


def _pass_on(keys: str, child: Child) -> None:
    if 'q' in keys.lower():
        raise StoppedError
    for key in re.findall('|'.join(map(re.escape, _KEYS)), keys):
        child.tell(Pressed(_KEYS[key]))


def _show(bar: tqdm[NoReturn], report: ChildReport) -> None:
    if isinstance(report, Playing):
        bar.total, bar.n = report.duration, report.at
        bar.set_description_str('paused' if report.paused else 'playing')


def _write(supervisor: Supervisor, line: str, stream: Stream) -> None:
    with tqdm.external_write_mode(file=supervisor.stderr):
        write_line(line, stream)
