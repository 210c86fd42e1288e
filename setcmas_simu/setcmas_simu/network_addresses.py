"""Addresses of this machine."""

from __future__ import annotations

import contextlib
import socket
import struct

_SIOCGIFADDR = 0x8915


def network_addresses() -> dict[str, str]:
    """Return the IPv4 addresses of network interfaces except loopback; none without fcntl."""
    try:
        import fcntl
    except ImportError:
        return {}
    addresses = {}
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        for _, name in socket.if_nameindex():
            with contextlib.suppress(OSError):  # it has no address
                request = struct.pack('256s', name.encode()[:15])
                answer = fcntl.ioctl(probe.fileno(), _SIOCGIFADDR, request)
                addresses[name] = socket.inet_ntoa(answer[20:24])
    return {name: ip for name, ip in addresses.items() if not ip.startswith('127.')}
