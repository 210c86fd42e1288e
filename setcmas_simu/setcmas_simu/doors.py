"""Doors for plugins: what installed packages offer by name, through their entry points.

What ships is declared in the same way, in the setup.cfg of each package. Nothing is looked up
before somebody asks for it, and nothing is imported but what is asked for.
"""

from __future__ import annotations

import difflib
import functools
import importlib.util
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeVar

from setcmas_simu.errors import SetcmasError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint, SelectableGroups

T = TypeVar('T')

_SHIPPED = ('setcmas', 'setcmas_simu', 'setcmas_ctrl', 'setcmas_expe', 'setcmas_tools')
"""Packages of ours: the one that pip installs, and those that colcon builds."""


class UnusableError(SetcmasError):
    """A plugin cannot be used.

    Attributes:
        reason: Why, in one line.
    """

    def __init__(self, kind: str, offer: Offer, reason: str) -> None:
        """Say whose it is, and why it cannot be used."""
        self.reason = ' '.join(reason.split())
        super().__init__(
            f"{kind} '{offer.name}' of package {offer.package} {offer.version} "
            f'cannot be used: {self.reason}'
        )


class MisfitError(Exception):
    """What a plugin offers is not what its door is for; the message says why."""


@dataclass(frozen=True)
class Offer:
    """A thing that a package offers by name.

    Attributes:
        name: What users call it.
        package: Name of the package that offers it.
        version: Version of that package.
        entry: Where it is found.
        hidden: Packages that offer another thing by this name; theirs is not reached.
    """

    name: str
    package: str
    version: str
    # importlib_metadata, where something imports it, makes others that cannot be compared with it.
    entry: EntryPoint = field(compare=False)
    hidden: tuple[str, ...] = ()

    @property
    def shipped(self) -> bool:
        """Whether it comes with setcmas."""
        return self.package.replace('-', '_') in _SHIPPED


@dataclass(frozen=True)
class _Names:
    """The names behind a door.

    Attributes:
        group: Group of entry points, such as 'setcmas.metrics'.
        kind: What one of the things is called in messages, such as 'metric'.
    """

    group: str
    kind: str

    def offers(self) -> dict[str, Offer]:
        """Return what there is, by name: what ships first, then plugins by name."""
        return _offers(self.group)

    def __contains__(self, name: str) -> bool:
        return self._spelled(name) in self.offers()

    def offer(self, name: str) -> Offer:
        """Return what is offered by a name; warns once if a plugin's is hidden by it.

        Raises:
            SetcmasError: There is none; the message has those that exist.
        """
        offers = self.offers()
        if not offers:
            raise SetcmasError(f'no {self.kind} is installed; install setcmas again with pip')
        if name not in self:
            near = difflib.get_close_matches(name, offers, n=1)
            hint = f'; did you mean {near[0]}?' if near else ''
            known = ', '.join(offers)
            raise SetcmasError(f"there is no {self.kind} '{name}'; must be one of {known}{hint}")
        offer = offers[self._spelled(name)]
        _warn_of_hidden(self.kind, offer)
        return offer

    def _spelled(self, name: str) -> str:
        """Return a name as it is offered, for - and _ mean the same to users."""
        return name if name in self.offers() else name.replace('-', '_')


@dataclass(frozen=True)
class Door(_Names, Generic[T]):
    """Objects of one kind, found by name.

    Attributes:
        check: Returns an object as what it must be, or raises MisfitError.
    """

    check: Callable[[object], T]

    def get(self, name: str) -> T:
        """Return the object of a name, imported now if it is not yet.

        Raises:
            SetcmasError: There is none.
            UnusableError: It raises while it is imported, or it does not fit.
        """
        offer = self.offer(name)
        try:
            return self.check(offer.entry.load())
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # a plugin may even call sys.exit while it is imported
            raise UnusableError(self.kind, offer, _reason(error)) from error

    def usable(self, warn: Callable[[str], None]) -> dict[str, T]:
        """Return all objects by name; what cannot be used is left out and told to `warn`."""
        found = {}
        for name in self.offers():
            try:
                found[name] = self.get(name)
            except UnusableError as error:
                warn(str(error))
        return found


@dataclass(frozen=True)
class ScriptDoor(_Names):
    """Scripts, found by name as files: each robot runs them in a fresh module."""

    def file(self, name: str) -> Path:
        """Return the file of the script of a name; the script is not run.

        Raises:
            SetcmasError: There is none.
            UnusableError: Its package has no such file, or it is in no package.
        """
        offer = self.offer(name)
        module = offer.entry.module
        if '.' not in module:  # else all that is installed would be modules beside the script
            hint = f'its module {module} must be in a package, such as my_{module}.{module}'
            raise UnusableError(self.kind, offer, hint)
        try:
            spec = importlib.util.find_spec(module)
        except Exception as error:  # of the package around it, which is imported
            raise UnusableError(self.kind, offer, _reason(error)) from error
        if spec is None or not spec.origin or not Path(spec.origin).is_file():
            raise UnusableError(self.kind, offer, f'its module {module} was not found')
        return Path(spec.origin)


def instance_of(kind: type[T]) -> Callable[[object], T]:
    """Return the check of a door whose objects are instances of a class."""

    def check(thing: object) -> T:
        if not isinstance(thing, kind):
            raise MisfitError(f'it is a {type(thing).__name__}; it must be a {kind.__name__}')
        return thing

    return check


@functools.cache
def _entries() -> SelectableGroups:
    """Return all entry points: reading those of every package takes about 10 ms.

    The type is that of Python 3.10; later ones have another with the same method.
    """
    from importlib.metadata import entry_points

    return entry_points()


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


def _offer(entry: EntryPoint) -> Offer | None:
    if entry.dist is None:
        return None
    return Offer(entry.name, entry.dist.metadata['Name'], entry.dist.version, entry)


@functools.cache
def _warn_of_hidden(kind: str, offer: Offer) -> None:
    for package in offer.hidden:
        print(
            f"warning: package {package} offers {kind} '{offer.name}' too; that of "
            f'{offer.package} is used',
            file=sys.stderr,
        )


def _reason(error: BaseException) -> str:
    """Return what went wrong, and where in the plugin's code it did."""
    if isinstance(error, MisfitError):
        return str(error)
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if frame.filename != __file__ and 'importlib' not in frame.filename
    ]
    place = f' ({Path(frames[-1].filename).name}, line {frames[-1].lineno})' if frames else ''
    return f'{type(error).__name__}: {error}{place}'
