"""Scenario of a command: from a file, and the options that override it."""

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
from setcmas_simu.option_groups import typed_words
from setcmas_tools.run.run import law_title
from setcmas_tools.run.run_folder import STUDY_TABLE
from setcmas_tools.run.run_info import INFO_FILE
from setcmas_tools.run.scenario import Scenario


def add_scenario_arguments(
    parser: argparse.ArgumentParser,
    without: Sequence[str] = (),
    parts: Sequence[str] = ('time', 'law', 'communication', 'safety', 'robots'),
) -> None:
    """Add a scenario file, and options for the values of `parts`, except those in `without`."""
    file = 'scenario file, such as square.yaml; options on the command line override it'
    parser.add_argument('scenario', nargs='?', type=Path, metavar='SCENARIO', help=file)
    added: set[str] = set()
    for part in parts:
        kind = Scenario.PARTS[part]
        kind.add_to(parser, {*without, *added}, quiet=True)
        added |= kind.options().keys()


def scenario_of(args: argparse.Namespace, needs_law: bool = True) -> Scenario:
    """Return the scenario of parsed arguments; unless it needs a law, it may have none.

    Raises:
        SetcmasError: A file has a mistake, or options contradict each other.
    """
    base = _named_scenario(args)
    typed = typed_values(args)
    if base is None and not needs_law:
        typed.setdefault('algo', '')
    if base is None and 'algo' not in typed:
        more = ', or --from' if 'earlier' in args else ''
        args.parser.error(f'there is no control law: add --algo, or a scenario file{more}')
    with typed_words():
        if base is None:
            return Scenario(law=LawOptions(algo=typed['algo'])).replace(**typed)
        return base.overridden(typed)


def scenario_to_simulate(args: argparse.Namespace) -> Scenario:
    """Return the scenario of a verb that simulates, checked; show its notes as warnings.

    Raises:
        SetcmasError: It has a mistake.
    """
    scenario = scenario_of(args)
    scenario.check()  # mistakes are found before anything starts
    scenario.start_poses()
    for note in (*scenario.notes_on_simulation, *scenario.safety.notes):
        warn(f'setcmas {args.verb}: {note}')
    return scenario


def add_from_argument(parser: argparse.ArgumentParser) -> None:
    """Add --from."""
    run = (
        'repeat the run in this folder from its own files, and compare the two; other options on '
        'the command line override its scenario'
    )
    parser.add_argument('--from', dest='earlier', type=Path, metavar='DIR', help=run)


def earlier_run(args: argparse.Namespace) -> Path | None:
    """Return the folder of the run that --from names; None if there is none to compare with.

    That of a study holds the scenario of its first run alone.
    """
    earlier: Path | None = args.earlier
    is_run = earlier and (earlier / INFO_FILE).is_file() and not (earlier / STUDY_TABLE).exists()
    return earlier if is_run else None


def typed_values(args: argparse.Namespace) -> dict[str, Any]:
    """Return the values of a scenario that are on the command line, by name."""
    return {k: v for part in Scenario.PARTS.values() for k, v in part.typed(args).items()}


def _named_scenario(args: argparse.Namespace) -> Scenario | None:
    """Return the scenario of a file or of a run, if the command line names one.

    Raises:
        SetcmasError: It names two, the run has no scenario, or the scenario has a mistake.
    """
    named: Path | None = args.scenario
    earlier: Path | None = getattr(args, 'earlier', None)
    if named and earlier:
        raise SetcmasError(f"'{named}' and --from {earlier} both say what to run; leave one out")
    source = named or earlier
    if source is None:
        return None
    file = source / INFO_FILE if earlier or source.is_dir() else source
    if earlier and not file.is_file():
        raise SetcmasError(
            f"there is no {INFO_FILE} in '{earlier}'; it must be the folder of a run or of a "
            'study; to simulate a recording, give its law and start poses (--algo, --pose) in '
            'place of --from'
        )
    scenario = Scenario.load(file)
    if scripts := scenario.scripts():
        folder = file.parent.resolve()
        texts = (str(one).removeprefix(f'{folder}{os.sep}') for one in scripts)
        warn(f'setcmas {args.verb}: running scripts from {source}: {", ".join(texts)}')
    return scenario


def output_folder(args: argparse.Namespace, scenario: Scenario) -> Path:
    """Return the requested folder, or one named after verb, scripts, date and time."""
    name = law_title(str(scenario.law.algo)).replace(', ', '_')
    return args.output or Path(time.strftime(f'{args.verb}_{name}_%Y%m%d-%H%M%S'))
