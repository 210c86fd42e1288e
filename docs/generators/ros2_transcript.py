"""Writes the transcript of the ros2 command line in docs/ros.md, from a simulation of its own.

python docs/generators/ros2_transcript.py     needs the commands `ros2 node, topic, param, service`
"""

from __future__ import annotations

import contextlib
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from generate import DOCS, spliced

sys.path.insert(0, str(DOCS.parent / 'tests'))

from ros_domain import reserved_domain

BIN = Path(sys.executable).parent
PROCESSES = ('simu --nb-robots 2', 'ctrl --algo consensus', 'record --output bag')
COMMANDS = (
    'ros2 node list',
    'ros2 node info /tb3_1/si_to_uni',
    'ros2 topic echo --once /tb3_1/cmd_cart_vel',
    'ros2 param set /tb3_2/si_to_uni komega 2.0',
    'ros2 param set /controllers algo nav_wp',
    'ros2 service list -t',
)
MOST_LINES = 24
REPEATED = ('set_parameters', 'get_parameter', 'describe_parameters', 'list_parameters')


@contextlib.contextmanager
def simulation(place: str) -> Iterator[None]:
    """Run a small fleet and its recorder until the end of the block."""
    processes = [
        subprocess.Popen([BIN / 'setcmas', *options.split()], cwd=place, stdout=subprocess.DEVNULL)
        for options in PROCESSES
    ]
    try:
        while '/tb3_2/cmd_vel' not in said('ros2 topic list'):
            time.sleep(0.1)
        time.sleep(2.0)  # the robots have moved
        yield
    finally:
        for process in reversed(processes):
            process.send_signal(signal.SIGINT)
            process.wait()


def said(command: str) -> str:
    """Return what a command prints."""
    # A daemon would fill its cache of names in its own time, and stay.
    words = [*shlex.split(command), '--no-daemon']
    words[0] = str(BIN / words[0])
    ended = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return ended.stdout


def shortened(text: str) -> list[str]:
    """Return the lines of an output without the services of parameters and empty lines."""
    lines = [
        line
        for line in text.splitlines()
        if line.strip() and not any(f'/{name}' in line for name in REPEATED)
    ]
    return lines if len(lines) <= MOST_LINES else [*lines[:MOST_LINES], '...']


def main() -> None:
    """Write the transcript into the page."""
    parts = []
    with reserved_domain() as domain, tempfile.TemporaryDirectory() as place:
        os.environ.update(ROS_DOMAIN_ID=str(domain), ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST')
        with simulation(place):
            for command in COMMANDS:
                parts += [f'$ {command}', *shortened(said(command))]
    page = DOCS / 'ros.md'
    transcript = '\n'.join(parts)
    page.write_text(spliced(page.read_text(), f'```text\n{transcript}\n```'))
    print(f'{page} written')


if __name__ == '__main__':
    main()
