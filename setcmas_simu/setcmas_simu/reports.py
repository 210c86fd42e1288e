"""Reports of node processes to the launcher: their kinds, their encoding, and the way there."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from collections.abc import Iterator, MutableMapping
from contextlib import suppress
from typing import Any, Generic, TypeVar

import msgspec

from setcmas_simu.script_calls import CurrentCall, ScriptCall, ScriptFailure

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

    def report(self, message: ProcessMessage) -> None:
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


class ProcessMessage(msgspec.Struct, frozen=True, tag=True):
    """Base class of messages between processes; each kind is a subclass with its fields."""


AnyMessage = TypeVar('AnyMessage', bound=ProcessMessage)


def encode(message: ProcessMessage) -> bytes:
    """Return a message as one line for `LineDecoder`."""
    # Starts with a line break, in case the previous line was cut off.
    return b'\n' + msgspec.json.encode(message) + b'\n'


class LineDecoder(Generic[AnyMessage]):
    """Turns the bytes of a pipe into messages."""

    def __init__(self, kinds: Any) -> None:
        self._decoder: msgspec.json.Decoder[AnyMessage] = msgspec.json.Decoder(kinds)
        self._rest = b''

    def feed(self, data: bytes) -> Iterator[AnyMessage]:
        """Yield the messages that these bytes complete.

        Skips lines that are no messages: a script can find the pipe and write to it.
        """
        *lines, self._rest = (self._rest + data).split(b'\n')
        for line in lines:
            try:
                yield self._decoder.decode(line)
            except (msgspec.DecodeError, UnicodeDecodeError):
                continue


class Ready(ProcessMessage, frozen=True):
    """The process is working, and ends cleanly on request."""


class Mistake(ProcessMessage, frozen=True):
    """The process ends with status 2: the user's input was invalid (already reported)."""

    text: str


class Started(ProcessMessage, frozen=True):
    """The controllers start to call the control laws."""

    robots: tuple[int, ...]
    law: str


class Failed(ProcessMessage, frozen=True):
    """A call failed for the first time with this message; the robot stops meanwhile."""

    call: ScriptCall
    text: str


class Ended(ProcessMessage, frozen=True):
    """The controllers end cleanly; `failed` calls failed or hung, `failures` are the periods."""

    failed: tuple[ScriptCall, ...]
    failures: tuple[ScriptFailure, ...] = ()


WRITES_S = 60.0
"""Seconds that a recorder gets to end: a busy machine takes long to index a large bag."""


class Recording(ProcessMessage, frozen=True):
    """The recorder has found the topics."""

    nb_topics: int


class Paused(ProcessMessage, frozen=True):
    """The robots of a simulation were paused or resumed on request."""

    paused: bool


Report = Ready | Mistake | Started | Failed | Ended | Recording | Paused


_PR_SET_PDEATHSIG = 1
_libc = ctypes.CDLL(None) if sys.platform == 'linux' else None


def end_with_parent(at_once: bool = False) -> None:
    """Let the kernel end this process with the one that has started it; on Linux only.

    It is asked to end (SIGTERM), or killed, if it is to end `at_once`. May be called between fork
    and exec.
    """
    if _libc:
        _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL if at_once else signal.SIGTERM)
