"""Lets a process end although a script's call would never return, or its threads still run."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import NoReturn

from setcmas_ctrl.scripts.stop_call import StopCall
from setcmas_ctrl.scripts.watch.call_watch import CallWatch
from setcmas_simu.ros.process import RosProcess


def end_stuck_script(
    process: RosProcess, watch: CallWatch, stop: Callable[[], None] = lambda: None
) -> None:
    """Let a stop signal end a call of a script, even one that swallows exceptions.

    Args:
        process: Handles the signals.
        watch: Knows whether a call is running.
        stop: Called before the process is ended by force.
    """
    signals = 0

    def on_stop_signal() -> None:
        nonlocal signals
        signals += 1
        if watch.running_s == 0:
            return
        if signals > 1:
            stop()
            os._exit(1)
        raise StopCall

    process.on_stop_signal = on_stop_signal


def end_process(status: int) -> NoReturn:
    """End this process with an exit status, whatever threads scripts may have started."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
