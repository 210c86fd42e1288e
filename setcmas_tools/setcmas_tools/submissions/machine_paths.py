"""Paths of the machine that grades, which students must not see in messages."""

from __future__ import annotations

import os
import re
import sys
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

_TEMPORARY = r'(?:/(?:setcmas_|tmp)[a-z0-9_]{8}(?![a-z0-9_]))+/?'  # as mkdtemp names them
_CUT = re.compile(r'/[^\s\'"]*(?=\.\.\.)')


def without_paths(text: str) -> str:
    """Return a message without the folders of this machine.

    Files of a submission and of packages are relative to its folder or to that of the packages;
    the home, the environment and the current folder of whoever grades become '…'.
    """
    temporary = '|'.join(map(re.escape, _places([tempfile.gettempdir()])))
    text = re.sub(f'(?:{temporary}){_TEMPORARY}', '', text)
    packages, private = _places(_roots()), _places(_private())
    for place in packages:
        text = text.replace(f'{place}/', '')
    for place in private:
        text = re.sub(rf'{re.escape(place)}(?![\w.-])', '…', text)
    places = [*packages, *private]

    def shortened(cut: re.Match[str]) -> str:
        return '…' if any(place.startswith(cut[0]) for place in places) else cut[0]

    return _CUT.sub(shortened, text)


def _roots() -> Iterator[str]:
    """Yield the folders of modules; loading a law adds its folder, perhaps a package."""
    yield from (one for one in sys.path if one and not Path(one, '__init__.py').exists())


def _private() -> Iterator[str]:
    yield from (sys.prefix, sys.base_prefix)
    with suppress(OSError, RuntimeError):
        yield str(Path.cwd())
        yield str(Path.home())


def _places(folders: Iterable[str]) -> list[str]:
    """Return folders as given and resolved, longest first; without the root."""
    found = {place for one in folders for place in (one, os.path.realpath(one))}
    return sorted((place.rstrip('/') for place in found if len(place) > 1), key=len, reverse=True)
