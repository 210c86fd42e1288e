"""Lets a stop signal end a call of a script that would never return."""

from __future__ import annotations

import os
from collections.abc import Callable

from setcmas_ctrl.call_watch import CallWatch
from setcmas_ctrl.stop_call import StopCall
from setcmas_simu.nodes.ros_process import RosProcess


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
