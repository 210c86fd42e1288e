"""Identify gain, lag and delay of each robot from a run, and write a model file for --model.

Use an experiment whose robots start, stop and turn often.

Examples:
  setcmas identify out                           a run, into model.yaml
  setcmas offline --from out --model model.yaml  simulate that run with that model
  setcmas identify bag_20261121-160211 -o lab_a.yaml
  setcmas offline --algo consensus --pose 1:1,0 --model lab_a.yaml   a recording names no law
"""

from __future__ import annotations

import argparse
import functools
from pathlib import Path

from launch_scripts.terminal import warner
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.identified_robot import ENDINGS
from setcmas_simu.robots.model import LIMITS

_USUAL = 'burger'

_warn = warner('identify')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    model = 'model file (default: model.yaml)'
    run = 'folder of a run, or a bag with cmd_vel and odometry'
    parser.add_argument('run', type=Path, metavar='DIR', help=run)
    parser.add_argument(
        '-o', '--output', type=Path, default='model.yaml', metavar='FILE', help=model
    )
    parser.add_argument('--overwrite', action='store_true', help='overwrite an existing file')
    limits = "velocity limits of the robots (default: the run's)"
    parser.add_argument('--limits', choices=list(LIMITS), help=limits)


def main(args: argparse.Namespace) -> int:
    """Identify; return the exit status, 1 if the run suffices for no robot."""
    from setcmas_simu.robots.identified_robot import write_model_file
    from setcmas_tools.measures import identification
    from setcmas_tools.run.run import Run

    output: Path = args.output
    if output.suffix not in ENDINGS:
        raise SetcmasError(f"--output is '{output}'; it must end in {' or '.join(ENDINGS)}")
    if not output.parent.is_dir():
        raise SetcmasError(f"--output is '{output}'; create folder '{output.parent}' first")
    if output.exists() and not args.overwrite:
        raise SetcmasError(f"'{output}' already exists; choose another name, or add --overwrite")
    warn = functools.cache(_warn)  # each line once, though a bag is read twice
    run = Run.load(args.run, warn)
    found = identification.identify(run, warn)
    print(identification.identified_table(found))
    for note in identification.identified_notes(found):
        _warn(note)
    limits = args.limits or identification.limits_of(run)
    if limits is None:
        _warn(f'the recording has no velocity limits; using those of {_USUAL} (see --limits)')
    model = identification.model_of(found, limits or _USUAL)
    if model is None:
        return 1
    write_model_file(model, output, f'setcmas identify {args.run}')
    print(output)
    return 0
