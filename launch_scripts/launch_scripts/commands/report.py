"""Write a run as one page to hand in: replay, charts, plots, metrics and the script.

The page opens in any browser, from a mail too, without a server and without a network. With a
second run, such as an experiment beside its simulation, it shows that one as ghosts, and what
differs.

Examples:
  setcmas report out                             out.html
  setcmas report simulation experiment -o lab.html
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.terminal.terminal_output import teller
from setcmas_simu.errors import SetcmasError

_tell = teller('report')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        'runs',
        type=Path,
        nargs='+',
        metavar='DIR',
        help='a run, and another one beside it: folders of runs or of CSV files, or bags',
    )
    parser.add_argument(
        '-o',
        '--output',
        type=Path,
        metavar='FILE.html',
        help='the page (default: named after the run, in this folder)',
    )


def main(args: argparse.Namespace) -> int:
    """Write the page; returns the exit status."""
    from setcmas_tools.report.files import check_page, page_named_after, write_report

    if len(args.runs) > 2:
        raise SetcmasError(f'{len(args.runs)} runs are given; there must be one or two')
    page = args.output or page_named_after(args.runs[0])
    check_page(page)
    write_report(args.runs, page, _tell)
    print(page)
    return 0
