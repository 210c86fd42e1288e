"""Functions that tests run in processes of their own, which import them by name."""

import sys
import time
from pathlib import Path


def talk(warn):
    print('to stdout')
    print('to stderr', file=sys.stderr)
    sys.stdout.write('half a line')
    warn('a warning')
    return Path.cwd()


def fail(error, warn):
    raise error


def sleep(warn):
    time.sleep(1000)
