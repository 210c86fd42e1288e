"""Write a web page that runs laws: students open it, and need to install nothing.

The page has an editor, the exercises, and the player of runs. Python (Pyodide) runs in the
browser; what students write stays on their computer. Any web server serves the folder. Pyodide
comes from a content delivery network, or from a folder, for use without internet access: unpack
pyodide-0.27.7.tar.bz2 of its releases on GitHub.

Examples:
  setcmas site web                                 all laws and exercises
  python -m http.server -d web                     then open http://localhost:8000
  setcmas site web --exercise consensus lab.yaml   two exercises, one with a rubric of your own
  setcmas site web --pyodide pyodide --overwrite   for use without internet access
"""

from __future__ import annotations

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument('folder', type=Path, metavar='FOLDER', help='folder for the page')
    exercise = (
        'offer only these exercises, without the laws that solve them: names, or rubric files, '
        'from which the page takes only what students may see (default: all)'
    )
    parser.add_argument(
        '--exercise', nargs='+', action='extend', default=[], metavar='NAME', help=exercise
    )
    pyodide = 'folder to copy Pyodide from (default: jsDelivr, a content delivery network)'
    parser.add_argument('--pyodide', type=Path, metavar='FOLDER', help=pyodide)
    parser.add_argument('--overwrite', action='store_true', help='replace an existing page')


def main(args: argparse.Namespace) -> int:
    """Write the page; return the exit status."""
    from setcmas_tools.page.site_folder import check_folder, site, write_folder

    check_folder(args.folder, args.overwrite)
    write_folder(args.folder, site(args.exercise, args.pyodide))
    print(args.folder / 'index.html')
    print(f'serve the folder, such as with: python -m http.server -d {args.folder}')
    return 0
