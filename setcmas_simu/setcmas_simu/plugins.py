"""Plugins: objects of installed packages, found by name through entry points.

The built-in objects are found in the same way: the setup.cfg of each package lists them.
Nothing is imported before it is needed.
"""

from __future__ import annotations

import functools
import importlib.util
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from setcmas_simu.errors import SetcmasError, it_must_be

if TYPE_CHECKING:
    from importlib.metadata import Distribution, EntryPoint, SelectableGroups

T = TypeVar('T')

OUR_PACKAGES = ('setcmas', 'setcmas_simu', 'setcmas_ctrl', 'setcmas_expe', 'setcmas_tools')
"""The package that pip installs, and those that colcon builds."""


class PluginError(SetcmasError):
    """A plugin, with its kind and title, cannot be used; `reason` says why, in one line."""

    def __init__(self, kind: str, title: str, reason: str) -> None:
        super().__init__(kind, title, reason)
        self.reason = ' '.join(reason.split())

    def __str__(self) -> str:
        kind, title, _ = self.args
        return f'{kind} {title} cannot be used: {self.reason}'


class InvalidPluginError(Exception):
    """The object has the wrong type for its group; the message says why."""


@dataclass(frozen=True)
class Plugin:
    """An object of an installed package, imported through its entry point."""

    name: str
    package: str
    version: str
    # importlib_metadata, once imported, makes entry points that cannot be compared with these.
    entry: EntryPoint = field(compare=False)

    @property
    def title(self) -> str:
        """Its name and package for messages."""
        return f"'{self.name}' of package {self.package} {self.version}"

    @property
    def built_in(self) -> bool:
        """Whether it comes with setcmas."""
        return self.package.replace('-', '_') in OUR_PACKAGES


@dataclass(frozen=True)
class _Group:
    """The plugins of a kind ('metric'), whose entry points have a group ('setcmas.metrics')."""

    name: str
    kind: str

    def plugins(self) -> dict[str, Plugin]:
        """Return all plugins by name, the built-in ones first: of one name, the first counts."""
        return _plugins(self.name)

    def __contains__(self, name: str) -> bool:
        return self._spelled(name) in self.plugins()

    def plugin(self, name: str) -> Plugin:
        """Return the plugin with this name, or raise SetcmasError."""
        plugins = self.plugins()
        if not plugins:
            raise SetcmasError(f'no {self.kind} is installed; install setcmas again with pip')
        if name not in self:
            expected = it_must_be(f'one of {", ".join(plugins)}', name, plugins)
            raise SetcmasError(f"unknown {self.kind} '{name}'{expected}")
        return plugins[self._spelled(name)]

    def _spelled(self, name: str) -> str:
        """Return a name as its package spells it: users may type - for _."""
        return name if name in self.plugins() else name.replace('-', '_')


@dataclass(frozen=True)
class PluginGroup(_Group, Generic[T]):
    """Plugins that are Python objects; `check` returns an object or raises InvalidPluginError."""

    check: Callable[[object], T]

    def get(self, name: str) -> T:
        """Return the object with this name; import it first if necessary.

        Raises:
            SetcmasError: The name is unknown, or the object cannot be used (PluginError).
        """
        plugin = self.plugin(name)
        try:
            return self.check(plugin.entry.load())
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # a plugin may even call sys.exit during its import
            raise PluginError(self.kind, plugin.title, _reason(error)) from error

    def usable(self, warn: Callable[[str], None]) -> dict[str, T]:
        """Return all usable objects by name; warn of the others."""
        found = {}
        for name in self.plugins():
            try:
                found[name] = self.get(name)
            except PluginError as error:
                warn(str(error))
        return found


@dataclass(frozen=True)
class ScriptGroup(_Group):
    """Plugins that are scripts, found as files: each robot runs its script in a fresh module."""

    def file(self, name: str) -> Path:
        """Return the file of the script with this name, without running it.

        Raises:
            SetcmasError: The name is unknown, or its package has no such file (PluginError).
        """
        plugin = self.plugin(name)
        module = plugin.entry.module
        if '.' not in module:  # else site-packages would be the script's folder
            hint = f'its module {module} must be in a package, such as my_{module}.{module}'
            raise PluginError(self.kind, plugin.title, hint)
        try:
            spec = importlib.util.find_spec(module)
        except Exception as error:  # raised by the parent package, which is imported
            raise PluginError(self.kind, plugin.title, _reason(error)) from error
        if spec is None or not spec.origin or not Path(spec.origin).is_file():
            raise PluginError(self.kind, plugin.title, f'its module {module} was not found')
        return Path(spec.origin)


def a_function(form: str) -> Callable[[object], Callable[..., Any]]:
    """Return a check that objects can be called; `form` is what they must be, in words."""

    def check(thing: object) -> Callable[..., Any]:
        if not callable(thing):
            raise InvalidPluginError(f'it is a {type(thing).__name__}; it must be {form}')
        return thing

    return check


@functools.cache
def _entries() -> SelectableGroups:
    """Return all entry points; reading those of every package takes about 10 ms.

    The type is that of Python 3.10; later versions have another type with the same method.
    """
    from importlib.metadata import entry_points

    return entry_points()


def plugin_versions() -> dict[str, str]:
    """Return the versions of installed packages with plugins, by name."""
    groups = [group for group in _entries().groups if group.startswith('setcmas.')]
    plugins = [plugin for group in groups for plugin in _plugins(group).values()]
    return {plugin.package: plugin.version for plugin in plugins if not plugin.built_in}


@functools.cache
def _plugins(group: str) -> dict[str, Plugin]:
    found = [
        Plugin(entry.name, *_name_and_version(entry.dist), entry)
        for entry in _entries().select(group=group)
        if entry.dist
    ]
    plugins: dict[str, Plugin] = {}
    for plugin in sorted(found, key=lambda plugin: (not plugin.built_in, plugin.package)):
        plugins.setdefault(plugin.name, plugin)
    return plugins


@functools.cache
def _name_and_version(package: Distribution) -> tuple[str, str]:
    metadata = package.metadata  # is parsed at each access
    return metadata['Name'], metadata['Version']


def _reason(error: BaseException) -> str:
    """Return the error and its place in the plugin's code."""
    if isinstance(error, InvalidPluginError):
        return str(error)
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if frame.filename != __file__ and 'importlib' not in frame.filename
    ]
    place = f' ({Path(frames[-1].filename).name}, line {frames[-1].lineno})' if frames else ''
    return f'{type(error).__name__}: {error}{place}'
