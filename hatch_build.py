"""Entry points of the wheel: the plugins in the setup.cfg of each package."""

from __future__ import annotations

from configparser import ConfigParser
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface


class EntryPoints(MetadataHookInterface):
    """Copies the groups `setcmas.*`, so that they are written once for pip and colcon."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Add the entry points to the metadata of the wheel."""
        groups: dict[str, dict[str, str]] = {}
        for path in sorted(Path(self.root).glob('*/setup.cfg')):
            config = ConfigParser(delimiters='=')
            config.read(path)
            for group, lines in config['options.entry_points'].items():
                if group.startswith('setcmas.'):
                    pairs = (line.split('=') for line in lines.split('\n') if line)
                    found = {name.strip(): target.strip() for name, target in pairs}
                    groups.setdefault(group, {}).update(found)
        metadata['entry-points'] = groups
