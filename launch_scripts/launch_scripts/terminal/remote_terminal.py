"""Terminal over ssh: whether the person's side of the connection still answers."""

from __future__ import annotations

import math
import os
import select
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from launch_scripts.terminal.terminal import ESC, Keyboard, kept_terminal
from setcmas_simu.errors import SetcmasError

ASK_EVERY_S = 0.1
"""Time between an answer and the next question, in s."""

LATEST_S = 0.4
"""Longest time for an answer, in s: later, the person's keys would be as late."""

_FIRST_WITHIN_S = 2.0
_CATCHES_UP_S = 0.5  # keys that were typed while nothing answered may arrive this long after
_QUESTION, _ANSWER = f'{ESC}[5n', f'{ESC}[0n'
_ANSWER_THEMSELVES = {'tmux: server': 'tmux', 'screen': 'screen', 'mosh-server': 'mosh'}


@contextmanager
def open_operator_keyboard(holds_joystick: bool) -> Iterator[Keyboard]:
    """Read single keys of a person who must be there; restore the terminal at the end.

    Args:
        holds_joystick: Whether robots move only while a button of a joystick at this computer is
            held: then keys over ssh stop robots and nothing else.

    Raises:
        SetcmasError: Nobody would notice that the connection over ssh hangs.
    """
    is_remote = bool(os.environ.get('SSH_CONNECTION') or os.environ.get('SSH_TTY'))
    with kept_terminal(single_keys=True) as there:
        asks = there and is_remote and not holds_joystick
        yield RemoteKeyboard() if asks else Keyboard(there, only_stops=is_remote)


class RemoteKeyboard(Keyboard):
    """Reads keys over ssh, and asks the person's terminal several times a second for its status.

    Terminals answer Device Status Report, ESC [ 5 n, with ESC [ 0 n (ECMA-48, section 8.3.35): so
    does one at the other end of ssh, unless its window, its computer or the network hangs. Keys
    that may have been typed long ago only stop.
    """

    def __init__(self) -> None:
        """Ask for the first time.

        Raises:
            SetcmasError: The terminal does not answer, or another program answers for it.
        """
        super().__init__(there=True)
        self._asked, self._answered = -math.inf, -math.inf
        self._is_asking = False
        self._catches_up_until = math.inf
        if name := _between():
            raise SetcmasError(
                f'{name} answers in place of a terminal over ssh, so robots would drive on when '
                f'the connection hangs: run setcmas outside of {name}, {_OTHER_WAY}'
            )
        deadline = time.monotonic() + _FIRST_WITHIN_S
        while self._answered < 0:
            self.pressed()
            if time.monotonic() > deadline:
                raise SetcmasError(
                    'the terminal at the other end of ssh does not answer, so robots would drive '
                    f'on when the connection hangs: use another terminal, {_OTHER_WAY}'
                )
            select.select([sys.stdin], [], [], ASK_EVERY_S)
        self._catches_up_until = -math.inf

    def pressed(self) -> str:
        """Return the keys pressed since the last call; '' if none. Ask again when due."""
        keys = super().pressed()
        now = time.monotonic()
        is_answer = self._is_asking and _ANSWER in keys
        took = now - self._asked
        if self._is_asking and took > LATEST_S:
            self._catches_up_until = now + _CATCHES_UP_S
        self.is_attended = is_answer and took <= LATEST_S
        self.only_stops = now < self._catches_up_until
        if is_answer:
            self._is_asking, self._answered = False, now
        if not self._is_asking and now - self._answered >= ASK_EVERY_S:
            self._ask(now)
        return keys.replace(_ANSWER, '')

    def _ask(self, now: float) -> None:
        # Never waits: the output of a connection that hangs is full sooner or later.
        with suppress(OSError):
            terminal = os.open(os.ttyname(sys.stdin.fileno()), os.O_WRONLY | os.O_NONBLOCK)
            try:
                os.write(terminal, _QUESTION.encode())
            finally:
                os.close(terminal)
            self._is_asking, self._asked = True, now


_OTHER_WAY = 'or add --hold and hold the button of a joystick that is wired to this computer'


def _between() -> str:
    """Return which program between ssh and this process answers by itself; empty if none."""
    process = os.getppid()
    with suppress(OSError, ValueError, IndexError):
        while process > 1:
            name, rest = Path(f'/proc/{process}/stat').read_text().split('(', 1)[1].rsplit(')', 1)
            if known := _ANSWER_THEMSELVES.get(name.lower()):
                return known
            process = int(rest.split()[1])
    return ''
