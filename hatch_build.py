"""Parts of the wheel that colcon takes from the packages: plugins, and what ROS tools look for."""

from __future__ import annotations

from configparser import ConfigParser
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface


class EntryPoints(MetadataHookInterface):
    """Copies the groups `setcmas.*`, so that they are written once for pip and colcon."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Add the entry points to the metadata of the wheel."""
        groups: dict[str, dict[str, str]] = {}
        for path in sorted(Path(self.root).glob('*/setup.cfg')):
            for group, found in entry_points(path).items():
                if group.startswith('setcmas.'):
                    groups.setdefault(group, {}).update(found)
        metadata['entry-points'] = groups


class RosPackages(BuildHookInterface):
    """Adds what `ros2 run`, `launch` and `pkg` find by AMENT_PREFIX_PATH.

    That is, for each package: its entry in the index, package.xml, launch files, RViz
    configurations, and its executables.
    """

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002
        """Add the files."""
        data = build_data['shared_data']
        for manifest in Path(self.root).glob('*/package.xml'):
            package, name = manifest.parent, manifest.parent.name
            index = 'share/ament_index/resource_index/packages'
            data[str(package / 'resource' / name)] = f'{index}/{name}'
            for path in (manifest, *package.glob('launch/*.py'), *package.glob('rviz/*.rviz')):
                data[str(path)] = f'share/{name}/{path.relative_to(package)}'
            points = entry_points(package / 'setup.cfg').get('console_scripts', {})
            for executable, target in points.items():
                script = self._script(executable, target)
                data[str(script)] = f'lib/{name}/{executable}'

    def finalize(self, version: str, build_data: dict[str, Any], artifact: str) -> None:  # noqa: ARG002
        """Remove the scripts, which are in the wheel now."""
        self._place.cleanup()

    @cached_property
    def _place(self) -> TemporaryDirectory[str]:
        return TemporaryDirectory()

    def _script(self, executable: str, target: str) -> Path:
        module, _, function = target.partition(':')
        script = Path(self._place.name) / executable
        script.write_text(
            '#!/usr/bin/env python3\n'
            'import sys\n'
            f'from {module} import {function}\n'
            f'sys.exit({function}())\n'
        )
        script.chmod(0o755)
        return script


def entry_points(path: Path) -> dict[str, dict[str, str]]:
    """Return the entry points in a setup.cfg, by group and name; {} if there is none."""
    config = ConfigParser(delimiters='=')
    config.read(path)
    if not config.has_section('options.entry_points'):
        return {}
    groups = {}
    for group, lines in config['options.entry_points'].items():
        pairs = (line.split('=') for line in lines.split('\n') if line)
        groups[group] = {name.strip(): target.strip() for name, target in pairs}
    return groups
