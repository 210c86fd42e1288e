"""Makes the pictures of README.md, from runs of its own, into docs/pictures/.

python tests/pictures/readme_pictures.py                   all of them
python tests/pictures/readme_pictures.py trajectories
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

PICTURES = Path(__file__).parents[2] / 'docs' / 'pictures'
SETCMAS = str(Path(sys.executable).parent / 'setcmas')
MOST_BYTES = 200_000
COLOURS = 128


def save(source: Path, name: str) -> Path:
    """Write a picture as a small PNG.

    Args:
        source: Any image.
        name: What it is called in docs/pictures.
    """
    path = PICTURES / f'{name}.png'
    with Image.open(source) as image:
        small = image.convert('RGB').quantize(COLOURS, dither=Image.Dither.NONE)
    small.save(path, optimize=True)
    assert path.stat().st_size < MOST_BYTES, f'{path}: {path.stat().st_size} bytes'
    return path


def plot_of_a_run(folder: Path, plot: str, *options: str) -> Path:
    """Let robots run offline, and return one of the plots."""
    subprocess.run(
        [SETCMAS, 'offline', *options, '--output', str(folder)],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return folder / 'plots' / f'{plot}.png'


def trajectories(folder: Path) -> Path:
    """Show a leader that visits waypoints, and the formation around it."""
    options = ('--algo', 'leader_follower_formation', '--nb-robots', '5', '--duration', '60')
    return plot_of_a_run(folder, 'trajectories', *options)


def communication(folder: Path) -> Path:
    """Show when robots sent their states in an event-triggered consensus."""
    options = ('--algo', 'consensus', '--nb-robots', '8', '--event-triggered')
    return plot_of_a_run(folder, 'communication_instants', *options)


MAKERS = {maker.__name__: maker for maker in (trajectories, communication)}


def main() -> None:
    """Make the pictures that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('names', nargs='*', metavar='NAME', help=f'any of {", ".join(MAKERS)}')
    names = parser.parse_args().names or list(MAKERS)
    if unknown := set(names) - set(MAKERS):
        parser.error(f'{", ".join(unknown)} is none of {", ".join(MAKERS)}')
    PICTURES.mkdir(parents=True, exist_ok=True)
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            print(save(MAKERS[name](Path(folder) / 'run'), name))


if __name__ == '__main__':
    main()
