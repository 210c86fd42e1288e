"""Process that makes an offline run for another one, which outlives whatever a script does to it.

Run as `python -m setcmas_tools.offline.worker FOLDER`. The folder holds the arguments of
`simulate`. The process writes the run there, or the user's mistake, and during the run the board
and, when asked (SIGUSR1) or killed by a signal, its place in the script.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from setcmas_ctrl.scripts import robot_script
from setcmas_ctrl.scripts.output import named_output
from setcmas_ctrl.scripts.script_errors import summarise
from setcmas_simu.errors import SetcmasError
from setcmas_tools.offline import board
from setcmas_tools.offline.engine import simulate
from setcmas_tools.offline.parent import end_with_parent
from setcmas_tools.offline.where import tell_where

JOB, BOARD, RUN, MISTAKE = 'job', 'board', 'run', 'mistake'
"""Files in the folder."""

MISTAKEN, BROKEN = 2, 3
"""Exit statuses: a mistake of the user's, and a script that broke the simulation itself."""

_exit = os._exit


def main() -> NoReturn:
    """Make the run; whatever threads and clean-ups scripts have left, the process ends then."""
    folder = Path(sys.argv[1])
    end_with_parent()
    # Ctrl-C is the other process's to answer, also where a script would swallow it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, 'SIGALRM'):  # a script's alarm does nothing, as over ROS
        signal.signal(signal.SIGALRM, lambda *_: None)
    tell_where(folder)
    job = pickle.loads((folder / JOB).read_bytes())
    board.current = board.Board(folder / BOARD)
    robot_script.on_call = board.current.begin
    with named_output():  # threads of scripts print on until the very end
        status = _make_run(job, folder)
        for stream in (sys.__stdout__, sys.__stderr__):
            if stream is not None and not stream.closed:
                stream.flush()
        _exit(status)


def _make_run(job: dict[str, Any], folder: Path) -> int:
    try:
        begin = time.perf_counter()
        run = simulate(**job, warn=_warn, progress=only_in(os.getpid()))
        board.current.elapsed = time.perf_counter() - begin
        part = folder / f'{RUN}.part'
        part.write_bytes(pickle.dumps(run))
        part.replace(folder / RUN)
    except SetcmasError as error:
        (folder / MISTAKE).write_text(str(error), encoding='utf-8')
        return MISTAKEN
    except BaseException as error:  # a script has changed what the simulation is made of
        (folder / MISTAKE).write_text(summarise(error), encoding='utf-8')
        return BROKEN
    return 0


def _warn(message: str) -> None:
    print(message, file=sys.stderr, flush=True)


def only_in(process: int) -> Callable[[float], None]:
    """Return what ends a copy of this process, which a script has forked, at its next step."""

    def check(_: float) -> None:
        if os.getpid() != process:
            _exit(0)

    return check


if __name__ == '__main__':
    main()
