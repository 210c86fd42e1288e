"""Pipe from a node process to its launcher."""

from __future__ import annotations

import os
from collections.abc import MutableMapping
from contextlib import suppress

from setcmas_simu.reports.current_call import CurrentCall
from setcmas_simu.reports.reports import Message, Ready, encode

VARIABLE = 'SETCMAS_LAUNCHER'
"""Environment variable: descriptors of the pipe and of the memory of the current call, and the
prefix of error messages."""


class Launcher:
    """Launcher of this process, if any: `ros2 run` and `python -m` start processes without one."""

    def __init__(
        self, pipe: int | None, current_call: CurrentCall, mistake: str = 'error'
    ) -> None:
        """Report through a pipe, if any; `mistake` begins messages about invalid input."""
        self.mistake = mistake
        self._pipe = pipe
        self.current_call = current_call

    def report(self, message: Message) -> None:
        """Send a message; never block, never fail."""
        if self._pipe is not None:
            with suppress(OSError):  # launcher stuck or gone, or a script closed the pipe
                os.write(self._pipe, encode(message))

    def report_ready(self) -> None:
        """Report that other processes need not wait for this one any more."""
        self.report(Ready())


def connected_launcher(environment: MutableMapping[str, str] = os.environ) -> Launcher:
    """Return the launcher of this process; hide it from the children of this process."""
    words = environment.pop(VARIABLE, '').split(maxsplit=2)
    if not words:
        return Launcher(None, CurrentCall())
    pipe, memory = int(words[0]), int(words[1])
    os.set_inheritable(pipe, False)
    os.set_blocking(pipe, False)
    current_call = CurrentCall.shared(memory)
    os.close(memory)
    return Launcher(pipe, current_call, words[2])
