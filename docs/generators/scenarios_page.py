"""Keys of scenarios with their values, units and defaults."""

from __future__ import annotations

import re
from dataclasses import MISSING, fields

from setcmas_simu.option_groups import Option, default_of, plain
from setcmas_simu.option_kinds import Number, OneOf, Whole
from setcmas_tools.run.scenario import Scenario


def text() -> str:
    """Return a table of the keys of each part."""
    shown: set[str] = set()
    tables = []
    for name, part in Scenario.PARTS.items():
        defaults = {one.name: default_of(one) for one in fields(part)}
        rows = [
            f'| `{key}` | {_escaped(option.help)} | {_values(option)} | '
            f'{_default(option.default_text, defaults[key])} |'
            for key, option in part.options().items()
            if key not in shown
        ]
        shown |= part.options().keys()
        tables.append(
            '\n'.join([f'| {name} | meaning | value | default |', '|---|---|---|---|', *rows])
        )
    return '\n\n'.join(tables)


def _values(option: Option) -> str:
    """Return bounds and unit of numbers, the words of a list, or true or false."""
    if option.is_switch:
        return 'true or false'
    return option.kind.must_be if isinstance(option.kind, (Number, OneOf, Whole)) else ''


def _default(words: str, value: object) -> str:
    if words:
        return _escaped(words)
    if value is MISSING:
        return 'required'
    given = plain(value)
    return 'none' if given in (None, [], {}) else f'`{str(given).lower()}`'


def _escaped(words: str) -> str:
    """Return a help text in Markdown, with keys in place of options."""
    words = re.sub(r'--([a-z-]+)', lambda found: f'`{found[1].replace("-", "_")}`', words)
    words = words.removesuffix('; may be repeated')
    return words.replace('|', '\\|').replace('*', '\\*').replace('<', '&lt;').replace('%%', '%')
