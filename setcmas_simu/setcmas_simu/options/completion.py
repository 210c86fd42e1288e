"""Completion of names and files that an option accepts, for argcomplete."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any


def names_and_files(
    names: Callable[[], Iterable[str]], endings: tuple[str, ...] = ()
) -> Callable[..., list[str]]:
    """Return a completer of names, looked up on demand, and of files with endings such as 'py'."""

    def complete(prefix: str, **_: Any) -> list[str]:
        from argcomplete.completers import FilesCompleter

        files = FilesCompleter(endings)(prefix) if endings else []
        return [*(name for name in names() if name.startswith(prefix)), *files]

    return complete
