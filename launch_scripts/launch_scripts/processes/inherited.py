"""Variables that a terminal or a notebook leaves behind, and that break what they were not for."""

from __future__ import annotations

import os
import sys
import warnings


def leave_out_what_breaks() -> None:
    """Take out of the environment what would end this process or one that it starts.

    PYTHONWARNINGS=error makes errors of the remarks of other packages, ROS among them; a notebook
    sets MPLBACKEND to a backend that exists in its own kernel only.
    """
    os.environ.pop('PYTHONWARNINGS', None)
    if sys.warnoptions:
        warnings.resetwarnings()
        warnings.simplefilter('ignore')
    if os.environ.get('MPLBACKEND', '').startswith('module://'):
        del os.environ['MPLBACKEND']
