"""Reload of a process's scripts on every save (`--watch`)."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterable
from pathlib import Path

from setcmas_ctrl.controllers.controlled_fleet import ControlledFleet
from setcmas_ctrl.laws.script_imports import with_helpers
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.script_calls import Function

SETTLED_S = 0.25
"""Time in s without changes after which files count as saved."""

_ODD_SETTLED_S = 2.0  # editors may briefly delete or empty a file before they write it

_Signature = tuple[int, int, int]
_GONE: _Signature = (0, 0, 0)


class FileWatch:
    """Compares files with their state at the last check.

    Attributes:
        saved: The files that the last successful `poll` found saved.
    """

    def __init__(self, files: Iterable[Path]) -> None:
        self.saved: set[Path] = set()
        self._seen = {file: _signature(file) for file in files}
        self._changing: dict[Path, _Signature] = {}
        self._since = 0.0

    def poll(self, files: Iterable[Path], now: float) -> bool:
        """Return True once after each save of one of the files; `now` is in s, on a steady clock.

        A new file counts as saved, such as a module that was missing.
        """
        current = {file: _signature(file) for file in files}
        if current == self._seen:
            self._changing = current
            return False
        if current != self._changing:
            self._changing, self._since = current, now
        odd = any(size == 0 for _, size, _ in current.values())
        if now - self._since < (_ODD_SETTLED_S if odd else SETTLED_S):
            return False
        self.saved = {file for file, now_is in current.items() if now_is != self._seen.get(file)}
        self._seen = current
        return True


def _signature(file: Path) -> _Signature:
    with contextlib.suppress(OSError):
        status = file.stat()
        return status.st_mtime_ns, status.st_size, status.st_ino
    return _GONE


class ScriptReloader:
    """Replaces laws, conditions and conversions of a process by their scripts' newest version.

    The new laws start as in a new run: fresh state, the same random numbers, and t = 0 unless
    other processes share t; robots keep their poses. If a version does not load, the robots stop
    until the next version. In an experiment, a new version waits until the robots are paused.
    """

    def __init__(self, fleet: ControlledFleet) -> None:
        """Watch the scripts of a fleet in this process, and the modules they import."""
        self._fleet, self._node = fleet, fleet.node
        self._loaded = scripts = fleet.scripts
        condition = scripts.condition if fleet.senders else None
        others = [one for one in (condition, scripts.conversion) if isinstance(one, Path)]
        self._scripts = list(dict.fromkeys([*(law.path for law in scripts.laws), *others]))
        self._files = FileWatch(self._with_helpers())
        self._is_new = self._asked_to_pause = False

    def poll(self) -> None:
        """Look for a new version, and load it."""
        self._is_new = self._files.poll(self._with_helpers(), time.monotonic()) or self._is_new
        if not self._is_new:
            return
        if self._fleet.options.experiment and not self._fleet.monitor.is_paused:
            self._ask_to_pause()
            return
        self._is_new = self._asked_to_pause = False
        self._reload()

    def _with_helpers(self) -> set[Path]:
        return {file for script in self._scripts for file in with_helpers(script)}

    def _saved(self) -> str:
        """Return the names of the saved scripts; of all scripts if a helper module was saved."""
        saved = [script for script in self._scripts if script in self._files.saved]
        return ', '.join(script.name for script in saved or self._scripts)

    def _reload(self) -> None:
        log = self._node.get_logger()
        try:
            self._load()
        except SetcmasError as error:
            log.warning(
                f'{self._saved()} was saved with a mistake; its robots get zero velocity '
                f'until you correct it:\n    {error}'
            )
        else:
            robots = robots_in_words([law.robot for law in self._loaded.laws])
            is_shared = self._fleet.monitor.shares_t
            t = 't continues, as in other controllers' if is_shared else 't = 0'
            log.info(f'{self._saved()} was saved and reloaded for {robots}; {t}')

    def _load(self) -> None:
        """Load all scripts again, and reset t, errors and messages.

        Raises:
            SetcmasError: A script has a mistake; all robots stop.
        """
        fleet, scripts = self._fleet, self._loaded
        try:
            scripts.reload()
            for sender in fleet.senders:
                sender.broadcast = scripts.broadcast(sender.robot)
            fleet.load_conversions()
        except SetcmasError:
            scripts.laws = []
            raise
        finally:
            by_robot = {law.robot: law for law in scripts.laws}
            for controller in fleet.controllers:
                controller.law = by_robot.get(controller.robot)
                controller.reports = scripts.reports[Function.CONTROL]
            fleet.monitor.run_time.begin_anew()
            fleet.network.forget_messages()

    def _ask_to_pause(self) -> None:
        if not self._asked_to_pause:
            self._asked_to_pause = True
            self._node.get_logger().warning(
                f'{self._saved()} was saved, but the experiment is not paused: the robots '
                'keep the earlier version; pause to load the new one'
            )
