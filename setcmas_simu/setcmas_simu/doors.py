"""Doors for plugins: objects that installed packages offer by name, through entry points.

The objects that ship with setcmas are declared in the same way, in the setup.cfg of each package.
Nothing is imported before it is needed.
"""

from __future__ import annotations

import functools
import importlib.util
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeVar

from setcmas_simu.errors import SetcmasError, did_you_mean

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint, SelectableGroups

T = TypeVar('T')

_SHIPPED = ('setcmas', 'setcmas_simu', 'setcmas_ctrl', 'setcmas_expe', 'setcmas_tools')
"""Our packages: the one that pip installs, and those that colcon builds."""


class UnusableError(SetcmasError):
    """A plugin cannot be used.

    Attributes:
        reason: Why, in one line.
    """

    def __init__(self, kind: str, offer: Offer, reason: str) -> None:
        """Name the plugin, its package and the reason."""
        self.reason = ' '.join(reason.split())
        super().__init__(f'{kind} {offer.title} cannot be used: {self.reason}')


class MisfitError(Exception):
    """The plugin's object does not suit its door; the message says why."""


@dataclass(frozen=True)
class Offer:
    """An object that a package offers by name.

    Attributes:
        name: The name that users type.
        package: Name of the package.
        version: Version of that package.
        entry: Its entry point.
        hidden: Packages that offer another object under this name; setcmas ignores these.
    """

    name: str
    package: str
    version: str
    # importlib_metadata, once imported, makes entry points that cannot be compared with these.
    entry: EntryPoint = field(compare=False)
    hidden: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """Its name and package for messages."""
        return f"'{self.name}' of package {self.package} {self.version}"

    @property
    def shipped(self) -> bool:
        """Whether it comes with setcmas."""
        return self.package.replace('-', '_') in _SHIPPED


@dataclass(frozen=True)
class _Names:
    """The names behind a door.

    Attributes:
        group: Group of entry points, such as 'setcmas.metrics'.
        kind: Noun for one object in messages, such as 'metric'.
    """

    group: str
    kind: str

    def offers(self) -> dict[str, Offer]:
        """Return all offers by name: first those of setcmas, then plugins by name."""
        return _offers(self.group)

    def __contains__(self, name: str) -> bool:
        return self._spelled(name) in self.offers()

    def offer(self, name: str) -> Offer:
        """Return the offer with this name; warn once if it hides that of another package.

        Raises:
            SetcmasError: The name is unknown; the message lists all names.
        """
        offers = self.offers()
        if not offers:
            raise SetcmasError(f'no {self.kind} is installed; install setcmas again with pip')
        if name not in self:
            known = f'{", ".join(offers)}{did_you_mean(name, offers)}'
            raise SetcmasError(f"unknown {self.kind} '{name}'; must be one of {known}")
        offer = offers[self._spelled(name)]
        _warn_of_hidden(self.kind, offer)
        return offer

    def _spelled(self, name: str) -> str:
        """Return a name as its package spells it: users may type - for _."""
        return name if name in self.offers() else name.replace('-', '_')


@dataclass(frozen=True)
class Door(_Names, Generic[T]):
    """Objects of one kind, found by name.

    Attributes:
        check: Returns an object of the right type, or raises MisfitError.
    """

    check: Callable[[object], T]

    def get(self, name: str) -> T:
        """Return the object with this name; import it first if necessary.

        Raises:
            SetcmasError: The name is unknown.
            UnusableError: Its import fails, or it does not suit this door.
        """
        offer = self.offer(name)
        try:
            return self.check(offer.entry.load())
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # a plugin may even call sys.exit during its import
            raise UnusableError(self.kind, offer, _reason(error)) from error

    def usable(self, warn: Callable[[str], None]) -> dict[str, T]:
        """Return all usable objects by name, and warn of the others."""
        found = {}
        for name in self.offers():
            try:
                found[name] = self.get(name)
            except UnusableError as error:
                warn(str(error))
        return found


@dataclass(frozen=True)
class ScriptDoor(_Names):
    """Scripts, found by name as files: each robot runs its script in a fresh module."""

    def file(self, name: str) -> Path:
        """Return the file of the script with this name, without running it.

        Raises:
            SetcmasError: The name is unknown.
            UnusableError: The package has no such file, or the module belongs to no package.
        """
        offer = self.offer(name)
        module = offer.entry.module
        if '.' not in module:  # else site-packages would be the script's folder
            hint = f'its module {module} must be in a package, such as my_{module}.{module}'
            raise UnusableError(self.kind, offer, hint)
        try:
            spec = importlib.util.find_spec(module)
        except Exception as error:  # raised by the parent package, which is imported
            raise UnusableError(self.kind, offer, _reason(error)) from error
        if spec is None or not spec.origin or not Path(spec.origin).is_file():
            raise UnusableError(self.kind, offer, f'its module {module} was not found')
        return Path(spec.origin)


def instance_of(kind: type[T]) -> Callable[[object], T]:
    """Return a check that objects are instances of a class."""

    def check(thing: object) -> T:
        if not isinstance(thing, kind):
            raise MisfitError(f'it is a {type(thing).__name__}; it must be a {kind.__name__}')
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
    groups = sorted(group for group in _entries().groups if group.startswith('setcmas.'))
    offers = [_offer(entry) for group in groups for entry in _entries().select(group=group)]
    return {one.package: one.version for one in offers if one and not one.shipped}


@functools.cache
def _offers(group: str) -> dict[str, Offer]:
    offers: dict[str, Offer] = {}
    found = [offer for entry in _entries().select(group=group) if (offer := _offer(entry))]
    for offer in sorted(found, key=lambda offer: (not offer.shipped, offer.package)):
        first = offers.setdefault(offer.name, offer)
        if first.entry.value != offer.entry.value:
            offers[offer.name] = replace(first, hidden=(*first.hidden, offer.package))
    ours = {name: offer for name, offer in offers.items() if offer.shipped}
    return ours | {name: offers[name] for name in sorted(offers.keys() - ours.keys())}


def door_groups() -> list[str]:
    """Return the groups of entry points that setcmas reads; each has objects that ship."""
    return [group for group in _groups() if any(o.shipped for o in _offers(group).values())]


def unknown_groups() -> dict[str, list[str]]:
    """Return the packages with entry points in groups 'setcmas.*' that setcmas does not read."""
    others = {group: _offers(group) for group in _groups() if group not in door_groups()}
    return {
        group: sorted({offer.package for offer in offers.values()})
        for group, offers in others.items()
    }


def _groups() -> list[str]:
    return sorted(group for group in _entries().groups if group.startswith('setcmas.'))


def _offer(entry: EntryPoint) -> Offer | None:
    if entry.dist is None:
        return None
    return Offer(entry.name, entry.dist.metadata['Name'], entry.dist.version, entry)


@functools.cache
def _warn_of_hidden(kind: str, offer: Offer) -> None:
    for package in offer.hidden:
        print(
            f"warning: package {package} also offers {kind} '{offer.name}'; using that of "
            f'{offer.package}',
            file=sys.stderr,
        )


def _reason(error: BaseException) -> str:
    """Return the error and its place in the plugin's code."""
    if isinstance(error, MisfitError):
        return str(error)
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if frame.filename != __file__ and 'importlib' not in frame.filename
    ]
    place = f' ({Path(frames[-1].filename).name}, line {frames[-1].lineno})' if frames else ''
    return f'{type(error).__name__}: {error}{place}'
