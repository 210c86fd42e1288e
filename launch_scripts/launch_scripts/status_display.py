"""State of an experiment in the terminal: a line per robot, redrawn in place."""

from __future__ import annotations

import time
from typing import IO, cast

import msgspec

from launch_scripts.terminal import QueuedStream
from setcmas_expe.pause.console import Status
from setcmas_simu.errors import needs

with needs('lab'):
    from rich.console import Console, Group
    from rich.live import Live
    from rich.table import Table
    from rich.text import Text

_COLOURS = {
    'STOP HELD': 'bold white on red',
    'PAUSED': 'black on yellow',
    'STOPPED': 'black on yellow',
    'STARTING': 'black on green',
    'RUNNING': 'black on green',
}
RELEASE = 'R twice: release it; the robots stay paused  q: quit'
_STYLES = ('green', 'yellow', 'red')
_PLAIN_EVERY_S = 10.0
_SILENT_AFTER_S = 1.0  # statuses arrive five times a second
KEYS = 's: start  space: pause  Esc, e: stop (R R: release)  q: quit'


class StatusDisplay:
    """Shows messages, and below them the newest status.

    Without a terminal, the status is a plain line now and then.
    """

    def __init__(self, stream: QueuedStream) -> None:
        self._console = Console(file=cast(IO[str], stream), highlight=False)
        self._live: Live | None = None
        self._next_plain = 0.0
        self._plain_state: tuple[object, ...] = ()
        self._last: Status | None = None
        self._received = 0.0

    def show(self, status: Status) -> None:
        """Show a status in place of the previous one."""
        self._last, self._received = status, time.monotonic()
        self._draw(status)

    def note_silence(self) -> None:
        """Without news, show that the robots have presumably stopped."""
        last = self._last
        if last and not last.paused and time.monotonic() - self._received > _SILENT_AFTER_S:
            why = 'the pause node is silent: the bridge stops the robots'
            self.show(msgspec.structs.replace(last, paused=True, why=why))

    def _draw(self, status: Status) -> None:
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
        states = (_headline(status), *(robot.state for robot in status.robots))
        now = time.monotonic()
        if states != self._plain_state or now >= self._next_plain:
            self._plain_state, self._next_plain = states, now + _PLAIN_EVERY_S
            lines = [_headline(status)]
            for robot in status.robots:
                is_told = robot.reason in ('', robot.state.value)
                lines.append(f'{robot.name} {robot.state.value}')
                lines[-1] += '' if is_told else f' ({robot.reason})'
            self.write('; '.join(lines))


def _headline(status: Status) -> str:
    if status.emergency:
        return 'STOP HELD'
    if status.paused:
        return 'PAUSED'
    if status.is_starting:
        return 'STARTING'
    return 'RUNNING' if status.is_moving else 'STOPPED'


def picture(status: Status) -> Group:
    """Return a status as terminal output: the pause state, and a table of the robots."""
    # The reason gets the remaining width, and is cut in a narrow terminal.
    table = Table(box=None, pad_edge=False, expand=True)
    table.add_column('robot', min_width=max(len(robot.name) for robot in status.robots))
    for title, width in (('pose age', 8), ('battery', 7), ('speed', 8)):
        table.add_column(title, justify='right', min_width=width)
    table.add_column('state', min_width=7)
    table.add_column('reason', ratio=1, overflow='ellipsis', no_wrap=True)
    for robot in status.robots:
        table.add_row(
            robot.name,
            '-' if robot.pose_age is None else f'{robot.pose_age:.2f} s',
            '-' if robot.battery is None else f'{robot.battery:.0f} %',
            '-' if robot.speed is None else f'{abs(robot.speed):.2f} m/s',
            Text(robot.state.value, style=_STYLES[min(robot.level, 2)]),
            Text(robot.why or robot.reason),
        )
    headline = _headline(status)
    why = '' if headline == 'STOPPED' else status.why  # which is why they were started
    head = Text.assemble((f' {headline} ', _COLOURS[headline]), f'  {why}')
    keys = Text(RELEASE if status.emergency else KEYS, style='dim')
    for text in (head, keys):
        text.no_wrap, text.overflow = True, 'ellipsis'
    return Group(head, keys, table)
