"""List the control laws that --algo accepts, with what each does.

Examples:
  setcmas list
"""

from __future__ import annotations

import argparse
import ast
import tokenize
from pathlib import Path

from setcmas_ctrl.scripts.loader import ALIASES, builtin_folder, exercise_folder, scripts_in

FUNCTIONS = ('control', 'ctc')
"""What a file must define to be listed: a control law, or a triggering condition."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add no option: the verb has none."""
    del parser


def main(args: argparse.Namespace) -> int:
    """Print the list; returns the exit status."""
    del args
    builtins = _summaries(builtin_folder())
    aliases = {target: f' (also {alias})' for alias, target in ALIASES.items()}
    _print('built-in', builtins, aliases)
    _print('exercises, with --exercise', _summaries(exercise_folder()), {})
    hiding = dict.fromkeys(builtins, ' (goes before the built-in of this name)')
    _print('in this folder', _summaries(Path.cwd()), hiding)
    return 0


def summary_of(path: Path) -> str | None:
    """Return the first line of a script's docstring; None if it is no script of a robot."""
    try:
        with tokenize.open(path) as file:
            tree = ast.parse(file.read())
    except (OSError, SyntaxError, ValueError):
        return '(cannot be read: setcmas ctrl tells why)'
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    if not functions.intersection(FUNCTIONS):
        return None
    return (ast.get_docstring(tree) or '').partition('\n')[0]


def _summaries(folder: Path) -> dict[str, str]:
    return {
        path.stem: summary
        for path in scripts_in(folder)
        if (summary := summary_of(path)) is not None
    }


def _print(title: str, summaries: dict[str, str], notes: dict[str, str]) -> None:
    print(f'{title}:')
    width = max(map(len, summaries), default=0)
    for name, summary in summaries.items():
        print(f'  {name:{width}}  {summary}{notes.get(name, "")}'.rstrip())
    if not summaries:
        print('  none: setcmas new my_law writes one')
