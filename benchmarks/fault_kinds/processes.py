"""Processes of the experiment that die, hang, or end by a signal."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable

from rehearsal import BRIDGES, CTRL, PAUSE, Rehearsal

from fault_kinds.kind import Kind, Place


def _signal(module: str, signum: int) -> Callable[[Rehearsal], float]:
    return lambda r: r.kill(module, signum)


def _killed(module: str, line: str) -> Kind:
    return Kind(_signal(module, signal.SIGKILL), line)


def _hung(module: str, line: str) -> Kind:
    """Return the fault that a process stops, and goes on later."""
    return Kind(_signal(module, signal.SIGSTOP), line, lambda r: _go_on(r, module))


def _go_on(r: Rehearsal, module: str) -> None:
    r.kill(module, signal.SIGCONT)


KINDS = {
    'controller killed (-9)': _killed(CTRL, 'ctrl.*(killed|died)'),
    'bridge killed (-9)': _killed(BRIDGES, 'bridge process has died'),
    'pause node killed (-9)': _killed(PAUSE, 'pause.*(killed|died)'),
    'controller hung': _hung(CTRL, 'no command'),
    'bridge hung': _hung(BRIDGES, 'bridge process.*(silent|stalled)'),
    'pause node hung': _hung(PAUSE, 'pause node'),
    'setcmas expe hung': Kind(
        lambda r: r.signal(signal.SIGSTOP),
        'terminal does not answer',
        lambda r: os.kill(r.process.pid, signal.SIGCONT),
        place=Place.APART,
    ),
    'setcmas expe killed (-9)': Kind(lambda r: r.signal(signal.SIGKILL), '', place=Place.APART),
    'Ctrl-C': Kind(lambda r: r.press_ctrl_c(), ''),
    'SIGTERM': Kind(lambda r: r.signal(signal.SIGTERM), ''),
    'SIGHUP': Kind(lambda r: r.signal(signal.SIGHUP), ''),
    'terminal closed': Kind(lambda r: r.close_terminal(), ''),
}
