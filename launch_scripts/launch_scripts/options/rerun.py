"""Export of a run for the program rerun, `setcmas view RUN --rerun`."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

from launch_scripts.terminal.output_lines import warn
from setcmas_simu.errors import SetcmasError

BESIDE_RUN = Path()
"""Stands for a file in the folder of the run."""
_FILE_NAME = 'run.rrd'
_INSTALL = "pip install 'rerun-sdk>=0.39'"


def write_for_rerun(run: Path | None, file: Path) -> int:
    """Write a run as a file, and say so; returns the exit status.

    Args:
        run: The folder of a run, of its CSV files, a fleet.csv, or a bag.
        file: Where to write it; BESIDE_RUN for the folder of the run.

    Raises:
        SetcmasError: There is no such run, rerun-sdk is missing, or the file cannot be written.
    """
    if run is None:
        raise SetcmasError('--rerun writes a run: name it first, as in setcmas view out --rerun')
    if file != BESIDE_RUN and file.suffix != '.rrd':
        raise SetcmasError(f"--rerun: '{file}' must end in .rrd")
    if importlib.util.find_spec('rerun') is None:
        raise SetcmasError(f'rerun-sdk is needed and is missing: {_INSTALL}')
    from setcmas_tools.run.run import Run
    from setcmas_tools.run.source import find_run
    from setcmas_tools.viewers.rerun_file import write_rrd

    source = find_run(run)
    target = source.folder / f'{source.stem}{_FILE_NAME}' if file == BESIDE_RUN else file
    try:
        write_rrd(Run.load(run, lambda line: warn(f'setcmas view: {line}')), target)
    except OSError as error:
        raise SetcmasError(f"'{target}' cannot be written: {error.strerror}") from error
    print(f'{target}: rerun {os.fspath(target)} shows it')
    return 0
