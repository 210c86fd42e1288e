"""A node process's end of the pipe to its launcher."""

from __future__ import annotations

import os
from collections.abc import MutableMapping
from contextlib import suppress

from setcmas_simu.reports.current_call import CurrentCall
from setcmas_simu.reports.encoding import Message, encode

VARIABLE = 'SETCMAS_LAUNCHER'
"""Environment variable: descriptors of the pipe and of the memory of the current call, and
words that stand before a mistake."""


class Launcher:
    """The launcher, if there is one: `ros2 run` and `python -m` start processes without."""

    def __init__(
        self, pipe: int | None, current_call: CurrentCall, mistake: str = 'error'
    ) -> None:
        """Talk through a pipe's descriptor; None is nobody.

        Args:
            pipe: The descriptor.
            current_call: The memory of the current call.
            mistake: What stands before a mistake of the user, such as 'setcmas ctrl'.
        """
        self.mistake = mistake
        self._pipe = pipe
        self.current_call = current_call

    def tell(self, message: Message) -> None:
        """Send a message; never waits, and never fails."""
        if self._pipe is not None:
            with suppress(OSError):  # the launcher hangs or is gone, or a script closed the pipe
                os.write(self._pipe, encode(message))


def connected_launcher(environment: MutableMapping[str, str] = os.environ) -> Launcher:
    """Return the launcher of this process; what the process starts itself does not inherit it."""
    words = environment.pop(VARIABLE, '').split(maxsplit=2)
    if not words:
        return Launcher(None, CurrentCall())
    pipe, memory = int(words[0]), int(words[1])
    os.set_inheritable(pipe, False)
    os.set_blocking(pipe, False)
    current_call = CurrentCall(memory)
    os.close(memory)
    return Launcher(pipe, current_call, words[2])
