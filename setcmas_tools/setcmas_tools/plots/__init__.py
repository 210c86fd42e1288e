"""Plots of a run."""

import logging
import os
import sys
import tempfile
from pathlib import Path


def _prepare_matplotlib() -> None:
    """Keep messages of matplotlib's import from the user.

    They would flood a script's `logging.basicConfig(level=DEBUG)`. If the home folder is not
    writable, matplotlib's files go elsewhere.
    """
    for name in ('matplotlib', 'PIL'):
        if logging.getLogger(name).level == logging.NOTSET:
            logging.getLogger(name).setLevel(logging.WARNING)
    # It says that it builds a cache of fonts, which reads as if a script had printed it.
    logging.getLogger('matplotlib.font_manager').setLevel(logging.ERROR)
    if sys.platform != 'linux' or 'MPLCONFIGDIR' in os.environ:
        return
    config = os.environ.get('XDG_CONFIG_HOME') or '~/.config'
    try:
        Path(config, 'matplotlib').expanduser().mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):  # RuntimeError: there is no home folder
        os.environ['MPLCONFIGDIR'] = str(Path(tempfile.gettempdir(), f'matplotlib-{os.getuid()}'))


_prepare_matplotlib()
