"""The state of an experiment in the terminal: a line for each robot that is redrawn in place."""

from __future__ import annotations

import time
from typing import IO, cast

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from launch_scripts.terminal.output_queue import QueuedStream
from setcmas_expe.pause.console_protocol import RobotStatus, Status

_STYLES = ('green', 'yellow', 'red')
_PLAIN_EVERY_S = 10.0
KEYS = 'space: start or pause   q: stop'


class StatusDisplay:
    """Shows messages, and below them the newest status.

    Where there is no terminal, the status is a plain line now and then.
    """

    def __init__(self, stream: QueuedStream) -> None:
        """Show on a stream."""
        self._console = Console(file=cast(IO[str], stream), highlight=False)
        self._live: Live | None = None
        self._next_plain = 0.0
        self._plain_state: tuple[object, ...] = ()

    def show(self, status: Status) -> None:
        """Show a status in place of the last one."""
        if not self._console.is_terminal:
            self._show_plainly(status)
        elif self._live is None:
            self._live = Live(
                picture(status),
                console=self._console,
                auto_refresh=False,
                redirect_stdout=False,
                redirect_stderr=False,
                transient=True,
            )
            self._live.start()
        else:
            self._live.update(picture(status), refresh=True)

    def write(self, line: str) -> None:
        """Show a message."""
        self._console.print(Text(line), soft_wrap=not self._console.is_terminal)

    def close(self) -> None:
        """Remove the status; the messages stay."""
        if self._live:
            self._live.stop()
            self._live = None

    def _show_plainly(self, status: Status) -> None:
        states = (status.paused, *(robot.state for robot in status.robots))
        now = time.monotonic()
        if states != self._plain_state or now >= self._next_plain:
            self._plain_state, self._next_plain = states, now + _PLAIN_EVERY_S
            self.write('; '.join([_headline(status), *map(_plain_line, status.robots)]))


def _headline(status: Status) -> str:
    return 'PAUSED' if status.paused else 'RUNNING'


def _plain_line(robot: RobotStatus) -> str:
    reason = f' ({robot.reason})' if robot.reason else ''
    return f'{robot.name} {robot.state.value}{reason}'


def picture(status: Status) -> Group:
    """Return what a terminal shows of a status: the pause state, and a table of the robots."""
    # The reason gets what the others leave, and is cut where a terminal is narrow.
    table = Table(box=None, pad_edge=False, expand=True)
    table.add_column('robot', min_width=max(len(robot.name) for robot in status.robots))
    for title, width in (('pose age', 8), ('battery', 7), ('speed', 8)):
        table.add_column(title, justify='right', min_width=width)
    table.add_column('state', min_width=7)
    table.add_column('reason', ratio=1, overflow='ellipsis', no_wrap=True)
    for robot in status.robots:
        table.add_row(
            robot.name,
            f'{float(robot.pose_age):.2f} s' if robot.pose_age else '-',
            f'{robot.battery} %' if robot.battery else '-',
            f'{abs(float(robot.speed)):.2f} m/s' if robot.speed else '-',
            Text(robot.state.value, style=_STYLES[min(robot.level, 2)]),
            Text(robot.reason),
        )
    colour = 'black on yellow' if status.paused else 'black on green'
    head = Text.assemble((f' {_headline(status)} ', colour), f'  {status.why}   {KEYS}')
    return Group(head, table)
