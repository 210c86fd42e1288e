"""How the messages of an experiment travel: over UDP alone, on one machine too."""

from __future__ import annotations

from collections.abc import MutableMapping

_TRANSPORTS = 'FASTDDS_BUILTIN_TRANSPORTS'


def use_udp_alone(environment: MutableMapping[str, str]) -> None:
    """Keep Fast DDS from shared memory, unless the user has chosen its transports.

    A process that hangs while it holds the lock of its queue in shared memory holds up whoever
    sends to it (SharedMemGlobal::Port::try_push of Fast DDS 2.14), and so those who are to stop
    the robots in its place. Over UDP nobody waits for a receiver. Processes whose topics stay on
    this machine do so without being told (setcmas_simu.nodes.dds_setup).
    """
    environment.setdefault(_TRANSPORTS, 'UDPv4')
