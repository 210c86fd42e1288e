"""List the control laws that --algo accepts, with what each does.

Examples:
  setcmas list
"""

from __future__ import annotations

import argparse
import ast
import tokenize
from pathlib import Path

from setcmas_ctrl.algorithm_loader import ALIASES, builtin_folder, scripts_in


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add no option: the verb has none."""
    del parser


def main(args: argparse.Namespace) -> int:
    """Print the list; returns the exit status."""
    del args
    _print_scripts('built-in', builtin_folder())
    _print_scripts('in this folder', Path.cwd())
    return 0


def summary_of(path: Path) -> str | None:
    """Return the first line of a script's docstring; None if it is no control script."""
    try:
        with tokenize.open(path) as file:
            tree = ast.parse(file.read())
    except (OSError, SyntaxError, ValueError):
        return '(cannot be read: setcmas ctrl tells why)'
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    if 'control' not in functions:
        return None
    return (ast.get_docstring(tree) or '').partition('\n')[0]


def _print_scripts(title: str, folder: Path) -> None:
    summaries = {
        path.stem: summary
        for path in scripts_in(folder)
        if (summary := summary_of(path)) is not None
    }
    print(f'{title}:')
    width = max(map(len, summaries), default=0)
    builtins = {path.stem for path in scripts_in(builtin_folder())}
    for name, summary in summaries.items():
        others = [alias for alias, target in ALIASES.items() if target == name]
        also = f' (also {", ".join(others)})' if others and folder == builtin_folder() else ''
        if folder != builtin_folder() and name in builtins:
            also = ' (goes before the built-in of this name)'
        print(f'  {name:{width}}  {summary}{also}'.rstrip())
    if not summaries:
        print('  none')
