"""Processes under test: started for real, their output kept, waited for by condition."""

import contextlib
import functools
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from unittest import mock

from launch_scripts.cli import main
from setcmas_simu.reports import end_with_parent

SETCMAS = [str(Path(sys.executable).parent / 'setcmas')]
SIMU = [sys.executable, '-m', 'setcmas_simu.simulator']
CTRL = [sys.executable, '-m', 'setcmas_ctrl.controllers.controller_processes']
PATIENT_LAB = ('--emulate', '--lab', str(Path(__file__).parent / 'data' / 'patient_lab.yaml'))
TIMEOUT_S = 120.0  # a machine may be busy with other things than these tests
NO_WINDOWS = {'CI': 'true'}
"""Environment of commands that would open a browser on a developer's desktop."""

die_with_parent = functools.partial(end_with_parent, at_once=True)
"""Have the kernel kill this process, even a stopped one, when the tests are killed."""


class Process:
    """A command that runs in a session of its own and writes to a log."""

    def __init__(self, command, log: Path, cwd, env) -> None:
        self.log = log
        with log.open('wb') as file:
            self.popen = subprocess.Popen(
                command,
                cwd=cwd,
                env={**env, 'PYTHONUNBUFFERED': '1'},
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                preexec_fn=die_with_parent,
            )

    @property
    def pid(self) -> int:
        return self.popen.pid

    def output(self) -> str:
        return self.log.read_text(errors='replace')

    def wait_for_output(self, text: str, timeout: float = TIMEOUT_S) -> str:
        """Wait until the process has written a text; fails if it ends or stays silent."""
        deadline = time.monotonic() + timeout
        while text not in self.output():
            ended = self.popen.poll() is not None
            if (ended and text not in self.output()) or time.monotonic() > deadline:
                raise AssertionError(f'{text!r} is not in the output:\n{self.output()}')
            time.sleep(0.02)
        return self.output()

    def end(self, signum: int = signal.SIGINT, timeout: float = TIMEOUT_S) -> int:
        """Send a signal and return the exit status."""
        self.popen.send_signal(signum)
        return self.wait(timeout)

    def wait(self, timeout: float = TIMEOUT_S) -> int:
        return self.popen.wait(timeout)

    def kill_group(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.popen.pid, signal.SIGKILL)
        self.popen.wait()


def gone(pid: int) -> bool:
    """Return whether a process has ended; nobody may have asked for its exit status."""
    import psutil  # other tests can do without

    try:
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def run_setcmas(*arguments: str, cwd=None, timeout: float = 2 * TIMEOUT_S, **env: str):
    """Run the setcmas command to its end."""
    return subprocess.run(
        [*SETCMAS, *arguments],
        cwd=cwd,
        env={**os.environ, **env},
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )


_INSTALLED = (sys.prefix, sys.base_prefix, str(Path(__file__).parents[1]))


def _is_of_a_script(module) -> bool:
    """Return whether a module is a file that a test has written: not ours, not installed."""
    file = getattr(module, '__file__', None) or next(iter(getattr(module, '__path__', ())), None)
    return bool(file) and not str(file).startswith(_INSTALLED)


def _is_installed(finder) -> bool:
    """Return whether a finder of modules is of an installed library, such as importlib_metadata's.

    That one has switched off Python's own: without both, no package is found.
    """
    module = sys.modules.get(getattr(finder, '__module__', ''))
    return str(getattr(module, '__file__', '')).startswith(_INSTALLED)


@contextlib.contextmanager
def restored_process():
    """Restore what commands and scripts change in this process: folder, environment, imports."""
    folder, environment, path = Path.cwd(), dict(os.environ), list(sys.path)
    modules, finders = set(sys.modules), list(sys.meta_path)
    try:
        yield
    finally:
        os.chdir(folder)
        if os.environ != environment:
            os.environ.clear()
            os.environ.update(environment)
        added = [one for one in sys.meta_path if one not in finders and _is_installed(one)]
        sys.path[:], sys.meta_path[:] = path, [*finders, *added]
        for name in sys.modules.keys() - modules:
            if _is_of_a_script(sys.modules[name]):
                del sys.modules[name]


def run_here(*arguments: str, cwd=None):
    """Run the setcmas command in this process, which is faster than starting one for it."""
    with (
        restored_process(),
        tempfile.TemporaryFile('w+', encoding='utf-8') as out,
        tempfile.TemporaryFile('w+', encoding='utf-8') as err,
    ):
        os.chdir(cwd or '.')
        try:
            with (
                contextlib.redirect_stdout(out),
                contextlib.redirect_stderr(err),
                mock.patch('sys.argv', ['setcmas', *arguments]),
            ):
                status = main(list(arguments))
        except SystemExit as error:
            status = error.code
        texts = [file.seek(0) or file.read() for file in (out, err)]
    return subprocess.CompletedProcess(arguments, status, *texts)


def refuses(*arguments: str, message: str, cwd) -> None:
    """Check that a command ends with status 2 and one line that holds a message."""
    result = run_here(*arguments, cwd=cwd)
    assert result.returncode == 2
    assert message in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1
