"""Run of a process to its own end; it may ask the user something."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Mapping, Sequence
from types import FrameType

from launch_scripts.processes.supervision.supervisor import STOP_SIGNALS


def run_to_end(command: Sequence[str], environment: Mapping[str, str]) -> int:
    """Run a process with this one's terminal; returns its exit status.

    Signals that ask to stop are handed on, so that the process ends in its own order.
    """
    process = subprocess.Popen(command, env=environment)

    def hand_on(signum: int, _frame: FrameType | None) -> None:
        process.send_signal(signum)

    previous = {signum: signal.signal(signum, hand_on) for signum in STOP_SIGNALS}
    try:
        status = process.wait()
    finally:
        for signum, handler in previous.items():
            signal.signal(signum, handler)
    return status if status >= 0 else 128 - status  # as shells tell it
