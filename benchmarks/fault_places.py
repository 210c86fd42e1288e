"""Places of rehearsals for benchmarks of faults: one machine, or two."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fault_kinds.kind import Kind, Place
from network_namespaces import UDP_ONLY, Network
from rehearsal import POSES, Rehearsal
from ros_peer import Peer

_EMULATED_LAB = [sys.executable, '-m', 'setcmas_expe.emulation.emulated_lab', '--nb-robots', '2']


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
    stack.enter_context(_emulated_lab(folder))
    peer = stack.enter_context(Peer(domain))
    return stack.enter_context(Rehearsal(peer, folder, *kind.options, lab=()))


def _two_machines(stack: contextlib.ExitStack, kind: Kind, folder: Path, domain: int) -> Rehearsal:
    network = stack.enter_context(Network('robots', 'laptop'))
    peers = ';'.join(network.addresses.values())
    os.environ.update(UDP_ONLY, ROS_STATIC_PEERS=peers)
    with network.on('robots'):
        stack.enter_context(_emulated_lab(folder))
        peer = stack.enter_context(Peer(domain))
    before = network.command('laptop', [])
    running = stack.enter_context(Rehearsal(peer, folder, *kind.options, before=before, lab=()))
    running.network = network
    return running


@contextmanager
def _emulated_lab(folder: Path, *options: str) -> Iterator[None]:
    """Run robots and motion capture on their own."""
    with (
        (folder / 'lab.txt').open('wb') as file,
        subprocess.Popen([*_EMULATED_LAB, *POSES, *options], stdout=file, stderr=file) as lab,
    ):
        try:
            yield
        finally:
            lab.terminate()
