"""ROS domains that nobody else on this machine uses at the same time."""

import contextlib
import random
import socket
from collections.abc import Iterator
from pathlib import Path

DOMAINS = range(1, 102)  # the domain IDs that are safe on every system
PORT_BASE, PORTS_PER_DOMAIN = 7400, 250  # DDS Interoperability Wire Protocol, section 9.6.1


def domains_in_use() -> set[int]:
    """Return the domains whose UDP ports some process has bound."""
    lines = Path('/proc/net/udp').read_text().splitlines()[1:]
    ports = [int(line.split()[1].rpartition(':')[2], 16) for line in lines]
    return {(port - PORT_BASE) // PORTS_PER_DOMAIN for port in ports}


@contextlib.contextmanager
def reserved_domain() -> Iterator[int]:
    """Reserve a domain for as long as the context lasts."""
    for number in random.sample(DOMAINS, len(DOMAINS)):
        # Not a file: test suites with other temporary folders see it, too.
        with socket.socket(socket.AF_UNIX) as lock:
            try:
                lock.bind(f'\0setcmas_test_domain_{number}')
            except OSError:
                continue
            if number in domains_in_use():
                continue
            yield number
            return
    raise RuntimeError('every ROS domain is in use')
