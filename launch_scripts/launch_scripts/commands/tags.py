"""Write the tags of robots and floor, and the board for the lens, as a PDF file to print.

Glue each robot's tag flat on its top, level, with the arrow to the robot's front. Keep the white
margin. Print at 100 %, and check the ruler at the bottom of the page.

Examples:
  setcmas tags --nb-robots 8                     tags.pdf, for A4, tags of 120 mm
  setcmas tags --nb-robots 4 --size 80 --paper letter -o lab.pdf
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

from setcmas_simu.errors import SetcmasError
from setcmas_simu.option_groups import Options, flag, option
from setcmas_simu.option_kinds import Number, OneOf, PathTo, Whole

_MOST_ROBOTS = 500
_MOST_FLOOR_TAGS = 20


@dataclass(frozen=True, kw_only=True)
class TagOptions(Options):
    """What to print."""

    nb_robots: int = option(Whole(1, _MOST_ROBOTS), 'number of robots; their tags are 1 to N')
    size: float = option(Number(above=0, unit='mm'), 'side of the black square', default=120.0)
    floor_tags: int = option(Whole(4, _MOST_FLOOR_TAGS), 'number of tags on the floor', default=4)
    paper: str = option(OneOf(('a4', 'letter')), 'paper', default='a4')
    output: Path = option(PathTo(), 'file', default=Path('tags.pdf'), short='-o')
    overwrite: bool = flag('overwrite an existing file')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    TagOptions.add_to(parser)


def main(args: argparse.Namespace) -> int:
    """Write the sheets; return the exit status."""
    from setcmas_expe.mocap.tag_sheets import SMALLEST_MM, largest_size, sheets, write_sheets

    options = TagOptions.of(args)
    output = options.output
    if output.suffix != '.pdf':
        raise SetcmasError(f"--output is '{output}'; it must end in .pdf")
    if output.exists() and not options.overwrite:
        raise SetcmasError(f"'{output}' already exists; choose another name, or add --overwrite")
    largest = largest_size(options.paper)
    if not SMALLEST_MM <= options.size <= largest:
        raise SetcmasError(
            f'--size is {options.size:g}; it must be from {SMALLEST_MM:g} to {largest:g} mm, '
            'which fits the paper'
        )
    pages = sheets(options.nb_robots, options.floor_tags, options.size, options.paper)
    nb_pages = write_sheets(output, pages)
    print(f'{output}: {nb_pages} pages; print them at 100 % and check the ruler')
    return 0
