"""Sandboxes of systems that allow less than this one."""

import os
import sys

_FORBIDDING = """
from setcmas_tools.offline.kernel_confinement import PrivateMounts
PrivateMounts.enter = lambda mounts: False
"""


def forbid_mounts(host, folder):
    """Let a host that has not started find no private mounts, as in a Docker container."""
    (folder / 'sitecustomize.py').write_text(_FORBIDDING)
    host._environment = {'PYTHONPATH': os.pathsep.join([str(folder), *filter(None, sys.path)])}
