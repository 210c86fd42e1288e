"""Motion capture drivers that ship, for the page on the lab."""

from __future__ import annotations

from configparser import ConfigParser
from pathlib import Path

from setcmas_expe.mocap.sources import MOCAP_SOURCES

_DECLARED = Path(__file__).parents[2] / 'setcmas_expe' / 'setup.cfg'


def text() -> str:
    """Return a table of the drivers: topic and type of its messages.

    Raises:
        SetcmasError: The installed entry points are missing or old.
    """
    config = ConfigParser(delimiters='=')
    config.read(_DECLARED)
    for line in config['options.entry_points'][MOCAP_SOURCES.name].split('\n'):
        if line:
            MOCAP_SOURCES.plugin(line.partition('=')[0].strip())
    lines = [
        '| `mocap.preset` | topic | type | read from |',
        '|---|---|---|---|',
    ]
    for name, plugin in MOCAP_SOURCES.plugins().items():
        if plugin.built_in:
            source = MOCAP_SOURCES.get(name)
            kind = source.message_type.rpartition('/')[2]
            lines.append(f'| `{name}` | `{source.topic}` | {kind} | {source.driver} |')
    return '\n'.join(lines)
