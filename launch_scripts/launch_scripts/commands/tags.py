"""Write the tags of robots and floor, and the board for the lens, as a PDF file to print.

Glue each robot's tag flat on its top, level, with the arrow to the robot's front. Keep the white
margin. Print at 100 %, and check the ruler at the bottom of the page.

Examples:
  setcmas tags --nb-robots 8                     tags.pdf, for A4, tags of 120 mm
  setcmas tags --nb-robots 4 --size 80mm --paper letter -o lab.pdf
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from setcmas_simu.errors import SetcmasError

_MM = {'mm': 1.0, 'cm': 10.0, 'm': 1000.0}
_SIZE = re.compile(rf'([0-9]+(?:\.[0-9]+)?) ?({"|".join(_MM)})')
_MOST_FLOOR_TAGS = 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    robots = 'number of robots; their tags have the numbers 1 to N'
    parser.add_argument('--nb-robots', metavar='N', required=True, help=robots)
    size = 'side of the black square, with mm, cm or m (default: 120mm)'
    parser.add_argument('--size', default='120mm', metavar='LENGTH', help=size)
    floor = 'number of tags on the floor, 4 or more (default: 4)'
    parser.add_argument('--floor-tags', default='4', metavar='N', help=floor)
    paper = 'a4 or letter (default: a4)'
    parser.add_argument('--paper', default='a4', metavar='PAPER', help=paper)
    parser.add_argument(
        '-o', '--output', type=Path, default='tags.pdf', metavar='FILE', help='file (tags.pdf)'
    )
    parser.add_argument('--overwrite', action='store_true', help='overwrite an existing file')


def main(args: argparse.Namespace) -> int:
    """Write the sheets; return the exit status."""
    from setcmas_expe.camera import tag_sheets
    from setcmas_simu.options.kinds import OneOf

    paper = OneOf(tuple(tag_sheets.PAPERS))
    if not paper.accepts(args.paper):
        raise SetcmasError(f"--paper is '{args.paper}'; it must be {paper.expected(args.paper)}")
    output = _output(args.output, args.overwrite)
    size = _size(args.size, tag_sheets.SMALLEST_MM, tag_sheets.largest_size(args.paper))
    nb_robots = _count('--nb-robots', args.nb_robots, 1, tag_sheets.FIRST_FLOOR_TAG - 1)
    nb_floor = _count('--floor-tags', args.floor_tags, 4, _MOST_FLOOR_TAGS)
    sheets = tag_sheets.pages(nb_robots, nb_floor, size, args.paper)
    try:
        nb_pages = tag_sheets.write_sheets(output, sheets)
    except OSError as error:
        raise SetcmasError(f"'{output}' cannot be written: {error.strerror}") from error
    print(f'{output}: {nb_pages} pages; print them at 100 % and check the ruler')
    return 0


def _output(path: Path, may_overwrite: bool) -> Path:
    if path.suffix != '.pdf':
        raise SetcmasError(f"--output is '{path}'; it must end in .pdf")
    if path.exists() and not may_overwrite:
        raise SetcmasError(f"'{path}' already exists; choose another name, or add --overwrite")
    return path


def _size(text: str, least: float, most: float) -> float:
    """Return a length in mm."""
    found = _SIZE.fullmatch(text)
    size = float(found[1]) * _MM[found[2]] if found else 0.0
    if not least <= size <= most:
        raise SetcmasError(
            f"--size is '{text}'; it must be a length from {least:g}mm to {most:g}mm, which fits "
            'the paper, such as 120mm'
        )
    return size


def _count(option: str, text: str, least: int, most: int) -> int:
    if not (text.isdecimal() and len(text) < 9 and least <= int(text) <= most):
        raise SetcmasError(
            f"{option} is '{text}'; it must be a whole number from {least} to {most}"
        )
    return int(text)
