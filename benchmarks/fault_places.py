"""Places of rehearsals for benchmarks of faults: one machine, or two."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fault_kinds.kind import Kind, Place
from network_namespaces import UDP_ONLY
from network_rehearsal import LAB, over_a_network, running
from rehearsal import Rehearsal
from ros_peer import Peer


@contextmanager
def rehearsal(kind: Kind, domain: int) -> Iterator[Rehearsal]:
    """Run an experiment where a fault wants it, with a peer beside its robots."""
    os.environ['ROS_DOMAIN_ID'] = str(domain)
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as stack:
        place = {
            Place.EMULATED: _children,
            Place.APART: _apart,
            Place.NETWORK: _two_machines,
        }
        yield place[kind.place](stack, kind, Path(name), domain)


def _children(stack: contextlib.ExitStack, kind: Kind, folder: Path, domain: int) -> Rehearsal:
    peer = stack.enter_context(Peer(domain))
    return stack.enter_context(Rehearsal(peer, folder, *kind.options))


def _apart(stack: contextlib.ExitStack, kind: Kind, folder: Path, domain: int) -> Rehearsal:
    os.environ.update(UDP_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE='SUBNET')
    stack.enter_context(running(LAB, folder / 'lab.txt'))
    peer = stack.enter_context(Peer(domain))
    return stack.enter_context(Rehearsal(peer, folder, *kind.options, lab=()))


def _two_machines(stack: contextlib.ExitStack, kind: Kind, folder: Path, domain: int) -> Rehearsal:
    return stack.enter_context(over_a_network(domain, folder, *kind.options))
