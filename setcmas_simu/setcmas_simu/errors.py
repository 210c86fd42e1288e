"""Errors that users can correct, such as the package of an extra that is missing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


class SetcmasError(Exception):
    """Wrong user input: the message has the value, what it must be, and what to do next.

    Commands print the message on one line and exit with status 2.
    """


def install_command(extra: str) -> str:
    """Return the command that installs the packages of an extra, such as 'study'."""
    return f"pip install 'setcmas[{extra}]'"


@contextmanager
def needs(extra: str) -> Iterator[None]:
    """Import packages of an extra in this context.

    Raises:
        SetcmasError: A package is missing; the message names the command that installs the extra.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        missing = f'{error.name} is needed and is missing'
        raise SetcmasError(f'{missing}; this installs it: {install_command(extra)}') from error
