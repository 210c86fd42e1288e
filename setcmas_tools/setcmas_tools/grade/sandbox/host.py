"""Process that holds submissions, each in a copy of itself.

A box starts it with the arguments FOLDER CONFINED and a socket as standard input. A job comes
with the socket that its copy (fork) answers on; a byte asks for more of the copy: its place in the
script, or its end. The process knows Python, numpy and what scripts import of setcmas, but no
rubric, solution or other submission, nor the environment of who started it.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import os
import signal
import socket
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import msgspec

from setcmas_tools.grade.sandbox.confinement import (
    OPEN_FILES,
    call_filter,
    confine_files,
    limit_amounts,
)
from setcmas_tools.grade.sandbox.job import EXIT, MOST_ASKED, NUMBER, PLACE, READY, Job
from setcmas_tools.grade.sandbox.served import serve
from setcmas_tools.offline.parent import end_with_parent

if TYPE_CHECKING:
    from pyseccomp import SyscallFilter

_exit = os._exit

_FOR_SCRIPTS = (
    'setcmas_ctrl.control.saturation',
    'setcmas_ctrl.network',
    'setcmas_ctrl.rviz_marker',
    'setcmas_ctrl.rviz_marker_array',
    'setcmas_simu.robots.model',
)
"""What scripts import of setcmas, whose files they cannot read."""


def main() -> None:
    """Hold submissions until there are no more."""
    folder, confined = Path(sys.argv[1]), sys.argv[2] == 'confined'
    end_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    orders = socket.socket(fileno=os.dup(0))
    os.dup2(nowhere := os.open(os.devnull, os.O_RDWR), 0)
    rules = call_filter() if confined else None
    for name in _FOR_SCRIPTS:
        importlib.import_module(name)
    if confined:
        confine_files(folder)
    orders.sendall(READY)
    gc.freeze()  # a copy does not touch, and so copy, what is there for all
    child = 0
    while True:
        message, ends, _, _ = socket.recv_fds(orders, MOST_ASKED, 1)
        if not message:
            _exit(0)
        if ends:
            child = os.fork()
            if not child:
                os.chdir(folder)
                _hold(message, ends[0], nowhere, rules)
            os.close(ends[0])
            orders.sendall(NUMBER.pack(child))
        elif message == PLACE:
            os.kill(child, signal.SIGUSR1)
        elif message == EXIT:
            os.kill(child, signal.SIGKILL)
            _, status = os.waitpid(child, 0)
            orders.sendall(NUMBER.pack(os.waitstatus_to_exitcode(status)))


def _hold(message: bytes, end: int, nowhere: int, rules: SyscallFilter | None) -> NoReturn:
    """Hold a submission in this process, which is a copy; it ends with its parent."""
    status = 1
    with contextlib.suppress(BaseException):
        job = msgspec.json.decode(message, type=Job)
        os.setsid()
        end_with_parent()
        os.dup2(nowhere, 2)
        os.dup2(end, 3)
        os.closerange(4, OPEN_FILES)
        limit_amounts(job.seconds)
        serve(job, socket.socket(fileno=3), rules)
        status = 0
    _exit(status)
