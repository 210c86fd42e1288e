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
from setcmas_simu.option_groups import typed_words
from setcmas_tools.run.run import law_title
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


def scenario_of(
    args: argparse.Namespace, needs_law: bool = True, earlier: Scenario | None = None
) -> Scenario:
    """Return the scenario of parsed arguments; unless it needs a law, it may have none.

    Args:
        args: The arguments, with a scenario file or without.
        needs_law: Whether a control law must be named.
        earlier: The scenario of an earlier run, in place of a file.

    Raises:
        SetcmasError: A file has a mistake, or options contradict each other.
    """
    base = earlier or _scenario_file(args)
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


def typed_values(args: argparse.Namespace) -> dict[str, Any]:
    """Return the values of a scenario that are on the command line, by name."""
    return {k: v for part in Scenario.PARTS.values() for k, v in part.typed(args).items()}


def _scenario_file(args: argparse.Namespace) -> Scenario | None:
    file: Path | None = args.scenario
    if file and file.is_dir():
        file = file / INFO_FILE
    if file is None:
        return None
    scenario = Scenario.load(file)
    name_scripts(args.verb, scenario, file)
    return scenario


def name_scripts(verb: str, scenario: Scenario, source: Path) -> None:
    """Say which scripts a scenario from a file or a folder is about to run."""
    folder = (source if source.is_dir() else source.parent).resolve()
    if scripts := scenario.scripts():
        texts = (str(one).removeprefix(f'{folder}{os.sep}') for one in scripts)
        warn(f'setcmas {verb}: running scripts from {source}: {", ".join(texts)}')


def output_folder(args: argparse.Namespace, scenario: Scenario) -> Path:
    """Return the requested folder, or one named after verb, scripts, date and time."""
    name = law_title(str(scenario.law.algo)).replace(', ', '_')
    return args.output or Path(time.strftime(f'{args.verb}_{name}_%Y%m%d-%H%M%S'))
