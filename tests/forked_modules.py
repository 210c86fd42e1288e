"""Processes of modules, forked from one that has imported what they need.

`python -m MODULE` imports rclpy and numpy first, which takes most of the processor time of a short
process of nodes. A fork has its own memory, signals and output, as every process has; `setcmas`
starts its nodes in new interpreters, in tests too.
"""

import ctypes
import functools
import gc
import importlib
import json
import os
import runpy
import select
import signal
import socket
import subprocess
import sys
import warnings
from pathlib import Path

from setcmas_simu.reports import end_with_parent

CLI = 'launch_scripts.cli'
MOST_BYTES = 1 << 17
_LIBC = ctypes.CDLL(None) if sys.platform == 'linux' else None

die_with_parent = functools.partial(end_with_parent, at_once=True)
"""Have the kernel kill this process, even a stopped one, when the tests are killed."""


class ForkServer:
    """A process that forks others; it ends with this one, and they with it."""

    def __init__(self) -> None:
        """Start it."""
        self._python_path = os.environ.get('PYTHONPATH')
        self._channel, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._process = subprocess.Popen(
            [sys.executable, __file__, str(theirs.fileno())],
            env=os.environ | {'PYTHONUNBUFFERED': '1'},
            pass_fds=[theirs.fileno()],
            start_new_session=True,
        )
        theirs.close()

    def ask(self, *request: object) -> int | None:
        """Call `_forked` or `_status` there."""
        self._channel.send(json.dumps(request).encode())
        return json.loads(self._channel.recv(MOST_BYTES))

    def would_import_as(self, environment: dict[str, str]) -> bool:
        """Return whether a Python with these variables would import the same modules."""
        return environment.get('PYTHONPATH') == self._python_path

    def close(self) -> None:
        """End it."""
        self._channel.close()
        self._process.wait()


class ForkedProcess:
    """A process of a module, with the methods of `subprocess.Popen`."""

    def __init__(self, server: ForkServer, arguments, log, cwd, env) -> None:
        self._server = server
        self.returncode = None
        self.pid = server.ask('fork', arguments, str(log), str(cwd or Path.cwd()), env)

    def poll(self) -> int | None:
        if self.returncode is None:
            self.returncode = self._server.ask('status', self.pid)
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        if self.poll() is None:
            ended = os.pidfd_open(self.pid)
            try:
                if not select.select([ended], [], [], timeout)[0]:
                    raise subprocess.TimeoutExpired(str(self.pid), timeout)
            finally:
                os.close(ended)
        return self.poll()

    def send_signal(self, signum: int) -> None:
        if self.poll() is None:
            os.kill(self.pid, signum)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)


def _serve(channel: socket.socket) -> None:
    """Fork processes until the tests end; in a fork, return what to run."""
    while data := channel.recv(MOST_BYTES):
        kind, *given = json.loads(data)
        if kind == 'status':
            pid, status = os.waitpid(given[0], os.WNOHANG)
            answer = os.waitstatus_to_exitcode(status) if pid else None
        else:
            [module, *arguments], *_ = given
            if module == CLI:
                importlib.import_module(f'launch_scripts.commands.{arguments[0]}')
            importlib.import_module(module)
            gc.freeze()
            with warnings.catch_warnings():  # from Python 3.12 on: LTTng's threads are no problem
                warnings.simplefilter('ignore')
                answer = os.fork()
            if not answer:
                channel.close()
                _begin(*given)
                del sys.modules[module]  # it becomes __main__
                runpy.run_module(module, run_name='__main__', alter_sys=True)
                return
        channel.send(json.dumps(answer).encode())


def _begin(arguments, log, cwd, env) -> None:
    # Threads of LTTng, which rclpy loads, do not survive a fork; at exit it would look for them.
    _LIBC.on_exit(ctypes.cast(_LIBC._exit, ctypes.c_void_p), None)
    os.setsid()
    die_with_parent()
    output = os.open(log, os.O_WRONLY | os.O_CREAT)
    silence = os.open(os.devnull, os.O_RDONLY)
    for number, target in enumerate((silence, output, output)):
        os.dup2(target, number)
    os.close(output)
    os.close(silence)
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(env)
    sys.argv = arguments
    sys.path[0] = cwd


if __name__ == '__main__':
    _serve(socket.socket(fileno=int(sys.argv[1])))
