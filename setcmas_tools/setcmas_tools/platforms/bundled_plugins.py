"""Plugins that a rubric uses, and wheels of their packages for bundles."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from importlib.metadata import Distribution
from pathlib import Path

from setcmas_ctrl.scripts.function import plain_values
from setcmas_ctrl.scripts.loader import ALGORITHMS, EXERCISES
from setcmas_simu.errors import SetcmasError
from setcmas_simu.plugins import Plugin, ScriptGroup
from setcmas_tools.grade.rubric import Rubric
from setcmas_tools.platforms.autograder import wheel_of

_COMPILED = ('.so', '.pyd', '.dylib')


def used_packages(rubric: Rubric) -> dict[str, Distribution]:
    """Return the packages, by name, whose metrics, robot models, laws or task a rubric uses."""
    found = {plugin.package: plugin.entry.dist for plugin in _used(rubric) if not plugin.built_in}
    return {name: dist for name, dist in sorted(found.items()) if dist}


def _used(rubric: Rubric) -> Iterator[Plugin]:
    metrics = {one.metric for scenario in rubric.scenarios for one in scenario.criteria}
    for name, plugin in _installed('setcmas.metrics').items():
        if any(metric == name or metric.startswith(f'{name}_') for metric in metrics):
            yield plugin
    named = {text for scenario in rubric.scenarios for text in scenario.base.named('model')}
    task = plain_values(rubric.solution).get('task') if rubric.solution else None
    for group, names in (('setcmas.robot_models', named), ('setcmas.tasks', {task})):
        yield from (one for name, one in _installed(group).items() if name in names)
    for scripts in (ALGORITHMS, EXERCISES):
        own = {name: one for name, one in scripts.plugins().items() if not one.built_in}
        yield from (one for name, one in own.items() if scripts.file(name) in rubric.files)
    if rubric.exercise:
        yield EXERCISES.plugin(rubric.exercise)


def _installed(group: str) -> dict[str, Plugin]:
    """Return the plugins of a group of entry points by name, without importing any."""
    return ScriptGroup(group, group).plugins()


def plugin_wheel(package: str, installed: Distribution) -> tuple[str, bytes]:
    """Return the name and the content of a wheel of an installed package of pure Python.

    Raises:
        SetcmasError: It has compiled parts, or its files are not found.
    """
    folders = plugin_folders(installed)
    compiled = [
        file for one in folders.values() for file in one.rglob('*') if file.suffix in _COMPILED
    ]
    if compiled or not folders or not installed.read_text('METADATA'):
        why = f'it has compiled parts, {compiled[0].name}' if compiled else 'its files are unknown'
        raise SetcmasError(
            f"the rubric uses package '{package}', which the bundle cannot carry: {why}; grade "
            'on a computer that has it'
        )
    return wheel_of(installed, folders)


def plugin_folders(installed: Distribution) -> dict[str, Path]:
    """Return the folder of each Python package that an installed package has, by name."""
    names = {entry.module.partition('.')[0] for entry in installed.entry_points}
    names |= {path.parts[0] for path in installed.files or () if path.name == '__init__.py'}
    specs = {name: importlib.util.find_spec(name) for name in sorted(names) if name.isidentifier()}
    return {
        name: Path(spec.origin).parent
        for name, spec in specs.items()
        if spec and spec.origin and spec.submodule_search_locations
    }
