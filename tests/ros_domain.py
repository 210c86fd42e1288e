"""ROS domains that no other test on this machine uses at the same time."""

import contextlib
import fcntl
import random
import tempfile
from collections.abc import Iterator
from pathlib import Path

DOMAINS = range(1, 102)  # the domain IDs that are safe on every system


@contextlib.contextmanager
def reserved_domain() -> Iterator[int]:
    """Reserve a domain for as long as the context lasts."""
    for number in random.sample(DOMAINS, len(DOMAINS)):
        path = Path(tempfile.gettempdir()) / f'setcmas_test_domain_{number}.lock'
        with path.open('w') as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield number
            return
    raise RuntimeError('every ROS domain is in use')
