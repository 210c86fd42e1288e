"""Keys of scenarios with units and defaults, as their parts have them."""

from __future__ import annotations

from dataclasses import MISSING, fields

from setcmas_simu.options.group import default_of
from setcmas_simu.options.option import plain
from setcmas_tools.scenario.scenario import Scenario


def text() -> str:
    """Return a table of the keys of each part."""
    shown: set[str] = set()
    tables = []
    for name, part in Scenario.PARTS.items():
        defaults = {one.name: default_of(one) for one in fields(part)}
        rows = [
            f'| `{key}` | {_escaped(option.help)} | {_unit(option.kind)} | '
            f'{_default(option.default_text, defaults[key])} |'
            for key, option in part.options().items()
            if key not in shown
        ]
        shown |= part.options().keys()
        tables.append('\n'.join([f'| {name} | | unit | default |', '|---|---|---|---|', *rows]))
    return '\n\n'.join(tables)


def _unit(kind: object) -> str:
    return str(getattr(kind, 'unit', ''))


def _default(words: str, value: object) -> str:
    if words:
        return _escaped(words)
    if value is MISSING:
        return 'required'
    given = plain(value)
    return 'none' if given in (None, [], {}) else f'`{str(given).lower()}`'


def _escaped(words: str) -> str:
    return words.replace('|', '\\|').replace('*', '\\*').replace('<', '&lt;').replace('%%', '%')
