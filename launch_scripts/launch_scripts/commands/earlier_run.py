"""The option --from: a run again, from what its folder keeps."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.per_robot import (
    format_per_robot,
    is_per_robot,
    mapped,
    parse_per_robot,
)
from setcmas_simu.robots.model import MODELS
from setcmas_tools.run.run_info import RunInfo, read_info


def add_from_argument(parser: argparse.ArgumentParser) -> None:
    """Add --from, beside which --algo may be left out."""
    for action in parser._actions:
        action.required = action.required and action.dest != 'algo'
    parser.add_argument(
        '--from',
        dest='earlier',
        type=Path,
        metavar='DIR',
        help='repeat the run in this folder, with its options and its files, and compare; or a '
        'run of a study, such as study/417; options typed beside it take precedence',
    )


def with_earlier_run(args: argparse.Namespace) -> tuple[argparse.Namespace, Path | None]:
    """Return the options of a run, those of the earlier run that --from names filled in.

    Returns:
        The options, and the folder of the earlier run; None if there is none to compare with.

    Raises:
        SetcmasError: There is no such run, or it cannot be repeated.
    """
    if not args.earlier:
        if not args.algo:
            args.parser.error('the following arguments are required: --algo, or --from')
        return args, None
    info, folder = read_info(args.earlier), args.earlier
    if info is None and args.earlier.name.isdecimal():
        info, folder = _run_of_study(args.earlier), args.earlier.parent
    if info is None:
        raise SetcmasError(
            f"there is no run.yaml in '{args.earlier}'; it must be a run's folder, or the folder "
            'of a study and the number of a run, such as study/417'
        )
    parser = args.parser
    known = {action.dest for action in parser._actions}
    values = _options(info, folder)
    if args.model or values.get('model'):  # which has limits of its own
        values.pop('limits', None)
    if values.get('emulate') and 'emulate' not in known:  # the lab has start poses of its own
        values['pose'] = _first_poses(args.earlier)
    parser.set_defaults(**{name: value for name, value in values.items() if name in known})
    again: argparse.Namespace = parser.parse_args(args.arguments)
    again.verb, again.arguments = args.verb, args.arguments
    return again, args.earlier if folder == args.earlier else None


def _run_of_study(path: Path) -> RunInfo | None:
    """Return what a run of a study is, by its path 'study/417'; None if there is no study."""
    from setcmas_tools.study.plan import read_plan
    from setcmas_tools.study.study_files import FILE_NAME

    if not (path.parent / FILE_NAME).is_file():
        return None
    return read_plan(path.parent).run_info(int(path.name))


def _options(info: RunInfo, folder: Path) -> dict[str, Any]:
    """Return the options of a run by name, its files as its folder keeps them."""
    values = {**info.parameters, 'seed': info.seed}
    values['set'] = [f'{n}={json.dumps(v)}' for n, v in info.parameters.get('set', {}).items()]
    limits = values.get('limits')
    if isinstance(limits, Mapping):  # those of a lab
        values['limits'] = _model(limits)
        values |= {'emulate': True, 'robot_rate': None}
    if values.get('arena'):
        values['arena'] = ','.join(map(str, values['arena']))
    for option, text in info.inputs.items():
        kept = mapped(text, lambda path: _kept(folder / path), option)
        values[option] = Path(kept) if option in ('poses', 'lab') else kept
    if is_per_robot(values.get('model') or ''):  # beside scripts there are models by name
        named = parse_per_robot(info.parameters['model'], 'model')
        values['model'] = format_per_robot({**named, **parse_per_robot(values['model'], 'model')})
    if 'algo' not in info.inputs:
        raise SetcmasError(
            f"the run in '{folder}' has no control script in its folder, so it cannot be repeated"
        )
    return {name: value for name, value in values.items() if value is not None}


def _first_poses(folder: Path) -> list[str]:
    """Return where the robots of a run were at t = 0, as --pose takes it."""
    from setcmas_tools.offline.given import pose_options
    from setcmas_tools.run.run import Run

    grid = Run.load(folder).counted_grid
    return pose_options(np.array([grid.x[:, 0], grid.y[:, 0], grid.theta[:, 0]]))


def _kept(path: Path) -> str:
    if not path.is_file():
        raise SetcmasError(f"'{path}' is missing, so the run cannot be repeated")
    return str(path)


def _model(limits: Mapping[str, Any]) -> str:
    """Return the name of the robots with the limits of a lab, 'ideal' if they have none."""
    speed = limits.get('V_max')
    return next((name for name, model in MODELS.items() if model.V_max == speed), 'ideal')
