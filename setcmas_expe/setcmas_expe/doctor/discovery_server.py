"""Discovery server, for networks that lose multicast.

Started from a shell, Fast DDS's own program does not find its libraries in every environment;
started from Python it does.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from pathlib import Path

from setcmas_simu.errors import SetcmasError

PORT = 11811
"""Default port of a discovery server (Fast DDS manual)."""

_PROGRAM = 'fast-discovery-server'


def server_command(address: str, port: int) -> list[str]:
    """Return the command of a server that listens on an IP address and a UDP port.

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


def main(argv: list[str] | None = None) -> None:
    """Become the server; Ctrl-C ends it."""
    parser = argparse.ArgumentParser(
        prog='python -m setcmas_expe.doctor.discovery_server',
        description='Run a discovery server: machines find each other through it, without '
        'multicast.',
    )
    parser.add_argument('--address', default='0.0.0.0', help='IP address (default: all)')
    parser.add_argument('--port', type=int, default=PORT, help='UDP port (default: %(default)s)')
    args = parser.parse_args(argv)
    try:
        command = server_command(args.address, args.port)
    except SetcmasError as error:
        parser.exit(2, f'{parser.prog}: {error}\n')
    os.execv(command[0], command)


if __name__ == '__main__':
    main()
