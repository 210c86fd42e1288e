"""Scenario of a command: a file or an earlier run, and the options that override it."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from launch_scripts.terminal import warn
from setcmas_ctrl.laws.control_options import LawOptions
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.start_poses import parse_pose_option
from setcmas_simu.options import typed_words
from setcmas_tools.run.run import law_title
from setcmas_tools.run.run_info import INFO_FILE, origin_changes, read_info
from setcmas_tools.run.scenario import Scenario

_STARTS: dict[str, Any] = {'poses': None, 'pose': (), 'random_poses': None}


def add_scenario_arguments(
    parser: argparse.ArgumentParser,
    without: Sequence[str] = (),
    parts: Sequence[str] = ('time', 'law', 'communication', 'safety', 'robots'),
) -> None:
    """Add a scenario file and its values as options, those of some parts, without some."""
    file = 'scenario file, such as square.yaml; options on the command line override it'
    parser.add_argument('scenario', nargs='?', type=Path, metavar='SCENARIO', help=file)
    added: set[str] = set()
    for part in parts:
        kind = Scenario.PARTS[part]
        kind.add_to(parser, {*without, *added}, quiet=True)
        added |= kind.options().keys()


def add_from_argument(parser: argparse.ArgumentParser) -> None:
    """Add --from."""
    run = (
        'repeat the run in this folder, or a run of a study, such as study/417, from its own '
        'files, and compare the two; other options on the command line override its scenario'
    )
    parser.add_argument('--from', dest='earlier', type=Path, metavar='DIR', help=run)


def scenario_of(args: argparse.Namespace, needs_law: bool = True) -> Scenario:
    """Return the scenario of parsed arguments; without a law unless it needs one.

    Raises:
        SetcmasError: A file has a mistake, or options do not go together.
    """
    base = _base(args)
    typed = typed_values(args)
    if base is None and not needs_law:
        typed.setdefault('algo', '')
    if base is None and 'algo' not in typed:
        more = ', or --from' if 'earlier' in args else ''
        args.parser.error(f'there is no control law: add --algo, or a scenario file{more}')
    with typed_words():
        if base is None:
            return Scenario(law=LawOptions(algo=typed['algo'])).replace(**typed)
        return base.replace(**_overriding(base, typed))


def typed_values(args: argparse.Namespace) -> dict[str, Any]:
    """Return the values of a scenario that are on the command line, by name."""
    return {k: v for part in Scenario.PARTS.values() for k, v in part.typed(args).items()}


def earlier_run(args: argparse.Namespace) -> Path | None:
    """Return the folder of the run that --from names; None if there is none to compare with."""
    earlier: Path | None = args.earlier
    return earlier if earlier and (earlier / INFO_FILE).is_file() else None


def _overriding(base: Scenario, typed: dict[str, Any]) -> dict[str, Any]:
    """Return typed values as changes of a scenario: settings and poses join its own."""
    changes = dict(typed)
    if 'set' in typed:
        changes['set'] = {**base.law.set, **typed['set']}
    if 'pose' in typed:
        named = {parse_pose_option(text)[0] for text in typed['pose']}
        own = (one for one in base.robots.pose if parse_pose_option(one)[0] not in named)
        changes['pose'] = (*own, *typed['pose'])
    if {'poses', 'random_poses'} & typed.keys():
        changes = {**_STARTS, **typed, **{k: v for k, v in changes.items() if k == 'set'}}
    if typed.get('model'):  # which has limits of its own
        changes.setdefault('limits', 'ideal')
    return changes


def _base(args: argparse.Namespace) -> Scenario | None:
    """Return the scenario of a file or an earlier run; None if there is neither."""
    earlier: Path | None = getattr(args, 'earlier', None)
    file: Path | None = args.scenario
    if earlier and file:
        raise SetcmasError(f"'{file}' and --from {earlier} both say what to run; leave one out")
    if file and file.is_dir():
        file = file / INFO_FILE
    if earlier:
        scenario, named = _earlier_scenario(earlier), earlier
    elif file:
        scenario, named = Scenario.load(file), file
    else:
        return None
    folder = (named if named.is_dir() else named.parent).resolve()
    if scripts := scenario.scripts():
        texts = (str(one).removeprefix(f'{folder}{os.sep}') for one in scripts)
        warn(f'setcmas {args.verb}: running scripts from {named}: {", ".join(texts)}')
    if earlier and (info := read_info(earlier)) and info.origin:
        for line in origin_changes(info.origin):
            warn(f'setcmas {args.verb}: {line}')
    return scenario


def _earlier_scenario(folder: Path) -> Scenario:
    if (folder / INFO_FILE).is_file():
        return Scenario.load(folder / INFO_FILE)
    from setcmas_tools.study.study_plan import FILE_NAME, read_plan

    if folder.name.isdecimal() and (folder.parent / FILE_NAME).is_file():
        return read_plan(folder.parent).scenario(int(folder.name))
    raise SetcmasError(
        f"there is no {INFO_FILE} in '{folder}'; it must be a run's folder, or the folder "
        'of a study and the number of a run, such as study/417; to simulate a recording, give '
        'its law and start poses (--algo, --pose) in place of --from'
    )


def output_folder(args: argparse.Namespace, scenario: Scenario) -> Path:
    """Return the requested folder, or one named after verb, scripts, date and time."""
    name = law_title(str(scenario.law.algo)).replace(', ', '_')
    return args.output or Path(time.strftime(f'{args.verb}_{name}_%Y%m%d-%H%M%S'))
