"""Check your law against an exercise, and see which criteria it meets.

Runs the law offline in the scenarios of its exercise; scripts from `setcmas new --exercise` name
their exercise. Each criterion gets a tick or a cross, with the measured and the required value; a
picture shows the paths of your robots over those of the solution. The exit status is 0 if the
law gets all points.

Examples:
  setcmas new my_law --from consensus --exercise     then fill in the parts marked TODO
  setcmas check my_law.py                            or law.ipynb, a notebook
  setcmas check my_law.py --rubric final.yaml --show
  setcmas check my_law.py --json                            for programs, such as an autograder
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from launch_scripts.commands.grade import RUBRIC
from setcmas_ctrl.laws.control_options import SCRIPT_FAILED
from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.run_folder import OfflineOptions

_ASCII = str.maketrans('✓✗', '+-')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument('law', metavar='LAW', help='your script or notebook, such as my_law.py')
    rubric = 'exercise or rubric file to check against (default: the one named in the script)'
    parser.add_argument('--rubric', '-R', metavar=RUBRIC, help=rubric)
    picture = 'picture (default: LAW_check.png)'
    parser.add_argument('--output', '-o', type=Path, metavar='FILE.png', help=picture)
    parser.add_argument('--show', action='store_true', help='open the picture in a window')
    as_json = 'print marks, hints and status as JSON, and draw no picture'
    parser.add_argument('--json', action='store_true', help=as_json)
    OfflineOptions.add_to(parser)


def main(args: argparse.Namespace) -> int:
    """Check the law; return the exit status."""
    from setcmas_tools.grade.check import Check, marks_of, opened, runs_apart
    from setcmas_tools.grade.mark_pictures import write_picture
    from setcmas_tools.grade.rubric import chosen_rubric

    if args.json and (args.show or args.output):
        raise SetcmasError('--json draws no picture; leave out --show and --output')
    call_timeout = OfflineOptions.of(args).call_timeout
    with opened(args.law) as (script, submission):
        rubric = chosen_rubric(script, args.rubric).shown()
        run = runs_apart(script, rubric, call_timeout)
        result = Check(marks_of(script, rubric, run, submission), rubric.hidden_points)
    picture = args.output or Path(f'{Path(result.marks.submission).stem}_check.png')
    if args.json:
        print(json.dumps(result.plain()))
        return 0 if result.marks.is_full else SCRIPT_FAILED
    text = str(result)
    encoding = sys.stdout.encoding or 'ascii'
    print(text if encoding.lower().startswith('utf') else text.translate(_ASCII))
    if rubric.references and not result.marks.is_full:
        print('explanations of mistakes need the solution, which this rubric does not have')
    if any(one.paths and one.paths[0].own for one in result.marks.scenarios):
        write_picture(result.marks.scenarios, picture, args.show)
        print(f'your paths over those of the solution: {picture}')
    return 0 if result.marks.is_full else SCRIPT_FAILED
