"""Commands and their options, as the parser knows them."""

from __future__ import annotations

import argparse
import re

from launch_scripts.cli import VERBS, build_parser

_SHORT = 30
"""Length below which the choices of an option stand beside its name."""


def text() -> str:
    """Return a table of the verbs, and for each its purpose, examples and tables of options."""
    rows = [f'| [`setcmas {verb}`](#setcmas-{verb}) | {VERBS[verb]} |' for verb in VERBS]
    table = '\n'.join(['| verb | |', '|---|---|', *rows])
    return '\n\n'.join([table, *map(_verb, VERBS)])


def _verb(verb: str) -> str:
    parser = _parser(verb)
    purpose, _, examples = (parser.description or '').partition('Examples:')
    parts = [f'## setcmas {verb}', _escaped(purpose.strip()), _examples(examples)]
    parts += [_options(parser, group) for group in parser._action_groups]
    parts.append(_table_of(parser.epilog or ''))
    return '\n\n'.join(part for part in parts if part)


def _parser(verb: str) -> argparse.ArgumentParser:
    """Return the parser of a verb's own options."""
    for action in build_parser(verb)._actions:
        if isinstance(action, argparse._SubParsersAction):
            return action.choices[verb]  # type: ignore[no-any-return]
    raise LookupError(verb)


def _examples(block: str) -> str:
    lines = []
    for line in block.strip().splitlines():
        command, *remark = re.split(r'\s{2,}', line.strip(), maxsplit=1)
        lines.append(f'{command}  # {remark[0]}' if remark else command)
    return '\n'.join(['```sh', *lines, '```']) if lines else ''


def _table_of(epilog: str) -> str:
    """Return a list such as 'faults:' and a line for each as a table."""
    title, *lines = epilog.splitlines() or ['']
    rows = [re.split(r'\s{2,}', line.strip(), maxsplit=1) for line in lines]
    table = [f'| `{name}` | {_escaped(purpose)} |' for name, purpose in rows]
    return '\n'.join([f'| {title.rstrip(":")} | |', '|---|---|', *table]) if table else ''


def _options(parser: argparse.ArgumentParser, group: argparse._ArgumentGroup) -> str:
    rows = [
        f'| `{_spelling(action)}` | {_meaning(parser, action)} |'
        for action in group._group_actions
        if action.help not in (None, argparse.SUPPRESS) and action.dest != 'help'
    ]
    title = {'positional arguments': 'argument', 'options': 'option'}.get(
        group.title or '', group.title or ''
    )
    return '\n'.join([f'| {title} | |', '|---|---|', *rows]) if rows else ''


def _spelling(action: argparse.Action) -> str:
    names = ', '.join(action.option_strings)
    if action.nargs == 0:
        return names
    choices = '{' + ','.join(map(str, action.choices or ())) + '}'
    value = action.metavar or (choices if 2 < len(choices) < _SHORT else action.dest.upper())
    return f'{names} {value}'.strip().replace('|', ' or ')


def _meaning(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    return _escaped(parser._get_formatter()._expand_help(action))


def _escaped(words: str) -> str:
    for character, replacement in (('|', '\\|'), ('*', '\\*'), ('<', '&lt;')):
        words = words.replace(character, replacement)
    return words
