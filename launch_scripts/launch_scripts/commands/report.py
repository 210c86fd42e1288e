"""Write a run as one page to hand in: replay, charts, plots, metrics and the script.

The page opens in any browser, even from an e-mail, without a server and without a network, and it
prints well. A second run, such as the simulation of an experiment, is drawn over the first one,
and the page lists the differences. Write your answers to an exercise in a Markdown file;
the page includes them.

Examples:
  setcmas report out                             writes out.html
  setcmas report simulation experiment -o lab.html
  setcmas report out --title 'Lab 2' --name 'Ada Lovelace, Alan Turing' --answers answers.md
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.terminal import warner
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.palettes import palette
from setcmas_tools.plots.plot_options import PaletteOptions

_warn = warner('report')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    runs = 'a run, or two to compare: folders of runs or of CSV files, or bags'
    parser.add_argument('runs', type=Path, nargs='+', metavar='DIR', help=runs)
    page = 'the page (default: named after the runs, in this folder)'
    parser.add_argument('-o', '--output', type=Path, metavar='FILE.html', help=page)
    title = 'title of the page (default: law and number of robots)'
    parser.add_argument('--title', default='', help=title)
    parser.add_argument('--name', default='', help='your name, or several, below the title')
    answers = 'answers to the questions of the exercise, in Markdown'
    parser.add_argument('--answers', type=Path, metavar='FILE.md', help=answers)
    PaletteOptions.add_to(parser)
    parser.add_argument('--overwrite', action='store_true', help='overwrite an existing page')


def main(args: argparse.Namespace) -> int:
    """Write the page; return the exit status."""
    from setcmas_tools.page.report_file import Cover, check_page, page_named_after, write_report

    if len(args.runs) > 2:
        raise SetcmasError(f'{len(args.runs)} runs given; name one or two')
    page = args.output or page_named_after(args.runs)
    check_page(page, args.overwrite)
    palette.set(args.palette)
    cover = Cover(args.title, args.name, args.answers)
    write_report(args.runs, page, _warn, cover)
    print(page)
    return 0
