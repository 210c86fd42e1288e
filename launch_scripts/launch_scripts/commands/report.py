"""Write a run as one page to hand in: replay, charts, plots, metrics and the script.

The page opens in any browser, even from an e-mail, without a server and without a network, and it
prints well. Write your answers to an exercise in a Markdown file; the page includes them.

Examples:
  setcmas report out                             writes out.html
  setcmas report out --title 'Lab 2' --name 'Ada Lovelace, Alan Turing' --answers answers.md
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.terminal import warner

_warn = warner('report')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    run = 'a run: its folder, a folder of CSV files, or a bag'
    parser.add_argument('run', type=Path, metavar='DIR', help=run)
    page = 'the page (default: named after the run, in this folder)'
    parser.add_argument('-o', '--output', type=Path, metavar='FILE.html', help=page)
    title = 'title of the page (default: law and number of robots)'
    parser.add_argument('--title', default='', help=title)
    parser.add_argument('--name', default='', help='your name, or several, below the title')
    answers = 'answers to the questions of the exercise, in Markdown'
    parser.add_argument('--answers', type=Path, metavar='FILE.md', help=answers)
    parser.add_argument('--overwrite', action='store_true', help='overwrite an existing page')


def main(args: argparse.Namespace) -> int:
    """Write the page; return the exit status."""
    from setcmas_tools.page.report_file import check_page, report_page, run_name, write_page
    from setcmas_tools.run.run import Run

    name = run_name(args.run)
    page = args.output or Path(f'{name}.html')
    check_page(page, args.overwrite)
    run = Run.load(args.run, _warn)
    write_page(page, report_page(run, name, _warn, args.title, args.name, args.answers))
    print(page)
    return 0
