"""Discovery server, for networks that lose multicast.

The `fastdds` script of the ROS wheels finds its server and libraries in some environments only;
started from Python it finds them in all.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.group import Options, option
from setcmas_simu.options.kinds import Kind, Whole

PORT = 11811
"""Default port of a discovery server (Fast DDS manual)."""

_PROGRAM = 'fast-discovery-server'


@dataclass(frozen=True, kw_only=True)
class ServerOptions(Options):
    """Address of a discovery server."""

    address: str = option(
        Kind(), 'IP address to listen on', default='0.0.0.0', default_text='all of them'
    )
    port: int = option(Whole(1, 65535, metavar='PORT'), 'UDP port', default=PORT)


def server_command(address: str, port: int) -> list[str]:
    """Return the command of a server with the number 0.

    Args:
        address: The IP address to listen on.
        port: The UDP port.

    Raises:
        SetcmasError: Fast DDS is not installed.
    """
    local = Path(sys.executable).parent / _PROGRAM
    program = str(local) if local.exists() else shutil.which(_PROGRAM)
    if not program:
        raise SetcmasError(
            f"{_PROGRAM} was not found: pip install 'ros-jazzy-rclpy[fastrtps]' installs it on "
            'Linux; or source the setup.bash of an installed ROS 2 Jazzy'
        )
    return [program, '-i', '0', '-l', address, '-p', str(port)]


def main(argv: list[str] | None = None) -> int:
    """Become the server; Ctrl-C ends it."""
    parser = argparse.ArgumentParser(
        prog='python -m setcmas_expe.doctor.discovery_server',
        description='Run a discovery server, through which machines find each other without '
        'multicast.',
    )
    ServerOptions.add_to(parser)
    options = ServerOptions.of(parser.parse_args(argv))
    try:
        command = server_command(options.address, options.port)
    except SetcmasError as error:
        parser.exit(2, f'{parser.prog}: {error}\n')
    os.execv(command[0], command)


if __name__ == '__main__':
    sys.exit(main())
