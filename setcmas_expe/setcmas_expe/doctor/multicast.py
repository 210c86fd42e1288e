"""Check of UDP multicast, by which ROS 2 finds other machines."""

from __future__ import annotations

import contextlib
import socket
import struct

from setcmas_expe.doctor.findings import NOTE, OK, Finding

_GROUP = '239.255.0.1'  # that of DDS discovery
_SIOCGIFADDR = 0x8915
_WAIT_S = 0.3
_WHAT = 'multicast'
_ADVICE = (
    'robots on other machines are not found by themselves: name them as network.static_peers in '
    'the lab file, or use a discovery server'
)


def network_addresses() -> dict[str, str]:
    """Return the IPv4 address of each network interface but the loopback, by name.

    None where the system does not tell, such as Windows.
    """
    try:
        import fcntl
    except ImportError:
        return {}
    addresses = {}
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        for _, name in socket.if_nameindex():
            with contextlib.suppress(OSError):  # it has none
                request = struct.pack('256s', name.encode()[:15])
                answer = fcntl.ioctl(probe.fileno(), _SIOCGIFADDR, request)
                addresses[name] = socket.inet_ntoa(answer[20:24])
    return {name: ip for name, ip in addresses.items() if not ip.startswith('127.')}


def multicast_works(address: str) -> bool:
    """Return whether a multicast datagram sent through an interface comes back to this host."""
    with contextlib.suppress(OSError), contextlib.ExitStack() as stack:
        receiver = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        sender = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        interface = socket.inet_aton(address)
        receiver.bind(('', 0))
        membership = socket.inet_aton(_GROUP) + interface
        receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        receiver.settimeout(_WAIT_S)
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, interface)
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
        sender.sendto(b'setcmas doctor', (_GROUP, receiver.getsockname()[1]))
        return receiver.recv(64) == b'setcmas doctor'
    return False


def multicast_finding() -> Finding:
    """Return through which interfaces multicast works, as far as this machine can tell."""
    addresses = network_addresses()
    if not addresses:
        return Finding(NOTE, _WHAT, 'no network is known but this machine itself')
    working = [name for name, address in addresses.items() if multicast_works(address)]
    if not working:
        return Finding(NOTE, _WHAT, f'blocked on {", ".join(addresses)}', _ADVICE)
    names = ', '.join(f'{name} ({addresses[name]})' for name in working)
    return Finding(OK, _WHAT, f'leaves through {names}; many Wi-Fi access points drop it there')
